#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "solvers/error.hpp"
#include "src/commands/work_precision.hpp"
#include "src/effects/coulomb.hpp"
#include "src/effects/induced_dipoles.hpp"
#include "src/granular/device/device.hpp"
#include "src/granular/integrator.hpp"
#include "src/scene/contact_steps.hpp"

namespace lichtenberg::work_precision {
namespace {

/// Gas of grains over a time before chaotic divergence.
struct GasSubject {
  Scene scene;
  std::vector<double> reference;  ///< d0, final positions, unwrapped across the box
};

/// Returns positions unwrapped across periodic sides.
std::vector<double> unwrapped(const Bodies& bodies) {
  std::vector<double> positions = bodies.position;
  for (std::size_t k = 0; k < positions.size(); ++k)
    positions[k] += bodies.image[k] * bodies.box.lengths[static_cast<int>(k % bodies.dimension)];
  return positions;
}

/// Runs the gas once.
class GasTrial : public Trial {
 public:
  GasTrial(const GasSubject& subject, Scene scene) : subject_(subject), scene_(std::move(scene)) {}

  void run() override {
    const double start = seconds_of_thread();
    granular::Gas gas(scene_);
    const auto integrator = granular::make_integrator(scene_.mechanics.integrator);
    const double energy = gas.energy().total(), end = scene_.stop.time;
    granular::Instant now = gas.instant();
    while (gas.time() < end) {
      const double left = end - gas.time(), count = std::ceil(left / integrator->longest_step(gas, now));
      now = integrator->step(gas, std::move(now), count <= 1 ? end : gas.time() + left / count, granular::Want::forces);
    }
    record_end(gas, energy);
    seconds_ = seconds_of_thread() - start;
  }
  std::vector<double> errors() const override {
    double squares = 0;
    for (std::size_t k = 0; k < positions_.size(); ++k)
      squares += (positions_[k] - subject_.reference[k]) * (positions_[k] - subject_.reference[k]);
    const double grains = static_cast<double>(subject_.scene.conductors.size());
    return {std::sqrt(squares / grains), energy_defect_};
  }
  std::int64_t work() const override { return steps_; }
  std::optional<double> measured_seconds() const override { return seconds_; }
  const std::vector<double>& positions() const { return positions_; }

 protected:
  /// Stores positions and energy error at the end. `energy`: total energy at the start.
  void record_end(granular::Gas& gas, double energy) {
    positions_ = unwrapped(gas.bodies());
    const granular::GasEnergy final_energy = gas.energy();
    const double turned_over =
        final_energy.kinetic + final_energy.dissipated;  // 0: grains at rest, whose energy balance is exact
    energy_defect_ = turned_over > 0 ? std::abs(final_energy.total() - energy) / turned_over : 0;
    steps_ = gas.contact_steps;
  }

  const GasSubject& subject_;
  Scene scene_;
  double seconds_ = 0;

 private:
  std::vector<double> positions_;
  double energy_defect_ = 0;
  std::int64_t steps_ = 0;
};

/// Runs the gas on a CUDA device, timed by its steps.
class GasOnDevice final : public GasTrial {
 public:
  using GasTrial::GasTrial;

  void run() override {
    granular::Gas gas(scene_);
    const double energy = gas.energy().total();
    const auto device = granular::device::make_cuda_gas(scene_);
    Checkpoint checkpoint = gas.save();
    device->load(checkpoint, gas.law(), false, 0, gas.surface());
    while (device->time() < scene_.stop.time) device->step(scene_.stop.time, 100);
    device->store(checkpoint);
    gas.restore(checkpoint);
    record_end(gas, energy);
    seconds_ = device->counts().seconds;
  }
  bool uses_other_memory() const override { return true; }
};

Scene with(const GasSubject& subject, Integrator integrator, double step, int contact_steps = 30) {
  Scene scene = subject.scene;
  scene.mechanics.integrator = integrator;
  scene.mechanics.step = step;
  scene.mechanics.contact_steps = contact_steps;
  return scene;
}

Candidate candidate(const GasSubject& subject, Settings settings, double cost, Scene scene) {
  return {std::move(settings), cost,
          [&subject, scene = std::move(scene)] { return std::make_unique<GasTrial>(subject, scene); }};
}

/// Step k of the sweep: the steps of charges and of contacts are halved together.
struct Step {
  explicit Step(int k) : length(0.08 / (1 << k)), contact_steps(10 << k), cost(1 << k) {}
  Settings settings() const { return {{"step", length}, {"contact steps", contact_steps}}; }

  double length;
  int contact_steps;
  double cost;
};

Candidate multirate_at(const GasSubject& subject, int k, const std::function<void(Scene&)>& change = {}) {
  const Step step(k);
  Scene scene = with(subject, Integrator::multirate, step.length, step.contact_steps);
  if (change) change(scene);
  return candidate(subject, step.settings(), step.cost, std::move(scene));
}

constexpr int halvings = 6;

Method multirate(const GasSubject& subject) {
  Method method{"multirate", "forces of charges constant over a step, contacts with substeps", {}};
  for (int k = 0; k < halvings; ++k) method.candidates.push_back(multirate_at(subject, k));
  return method;
}

Method on_device(const GasSubject& subject) {
  Method method{"multirate-cuda", "multirate on a CUDA device, by the time of its steps", {}};
  for (int k = 0; k < halvings; ++k) {
    const Step step(k);
    Scene scene = with(subject, Integrator::multirate, step.length, step.contact_steps);
    method.candidates.push_back({step.settings(), step.cost, [&subject, scene = std::move(scene)] {
                                   return std::make_unique<GasOnDevice>(subject, scene);
                                 }});
  }
  return method;
}

/// Returns multirate with the finest contact steps of the sweep. The remaining error is that of forces kept constant
/// over the outer step.
Method charges_held(const GasSubject& subject) {
  Method method{
      "multirate-charges", "the same with the finest contact substeps: error of constant forces of charges", {}};
  const int contact_steps = 10 << (halvings - 1);
  for (int k = 0; k < halvings; ++k) {
    const double step = 0.32 / (1 << k);
    method.candidates.push_back(
        candidate(subject, {{"step", step}}, 1, with(subject, Integrator::multirate, step, contact_steps)));
  }
  return method;
}

/// Returns the method with all steps chosen by accuracy.
Method by_accuracy(const GasSubject& subject) {
  Method method{"accuracy", "one accuracy for the sum of charge forces, the step and the contact substeps", {}};
  for (const double accuracy : {1e-1, 1e-2, 1e-3, 1e-4, 1e-5}) {
    Scene scene = with(subject, Integrator::multirate, INFINITY, contact_steps_for(accuracy));
    scene.effects.find<effects::CoulombOptions>()->accuracy = accuracy;
    method.candidates.push_back(
        candidate(subject, {{"accuracy", accuracy}}, 1 / std::sqrt(accuracy), std::move(scene)));
  }
  return method;
}

/// Returns multirate with steps so short that the accuracy of forces dominates the error.
Method force_accuracy(const GasSubject& subject) {
  Method method{"multirate-forces", "the same with short steps: error by the accuracy of forces", {}};
  for (const double accuracy : {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6}) {
    Scene scene = with(subject, Integrator::multirate, 0.01, 80);
    scene.effects.find<effects::CoulombOptions>()->accuracy = accuracy;
    method.candidates.push_back(candidate(subject, {{"accuracy", accuracy}}, 1, std::move(scene)));
  }
  return method;
}

/// Returns multirate with dipoles by another sum.
Method dipole_variant(const GasSubject& subject, periodic::DipoleSum variant) {
  Method method{"dipoles-" + std::string(name_of(variant)), "multirate with induced_dipoles.sum of that name", {}};
  for (int k = 0; k < halvings; ++k)
    method.candidates.push_back(multirate_at(
        subject, k, [&](Scene& scene) { scene.effects.find<effects::InducedDipolesOptions>()->sum = variant; }));
  return method;
}

Method fixed_steps(const GasSubject& subject, Integrator integrator, std::string description) {
  Method method{name_of(integrator), std::move(description), {}};
  for (int k = 0; k < halvings; ++k) {
    const double step = 0.01 / (1 << k);
    method.candidates.push_back(candidate(subject, {{"step", step}}, 1 << k, with(subject, integrator, step)));
  }
  return method;
}

std::vector<Method> all_methods(const GasSubject& subject) {
  std::vector<Method> all = {
      multirate(subject), on_device(subject),
      fixed_steps(subject, Integrator::verlet, "velocity Verlet with predicted velocities"),
      fixed_steps(subject, Integrator::gear, "Gear's predictor and corrector of order 6"),
      fixed_steps(subject, Integrator::gear_printed, "the same with G 3.41's coefficients as printed")};
  const auto* coulomb = subject.scene.effects.find<effects::CoulombOptions>();
  if (coulomb) all.push_back(charges_held(subject));
  if (coulomb && coulomb->sum == effects::CoulombSum::mesh && !(coulomb->cutoff && coulomb->mesh && coulomb->order))
    all.insert(all.end(), {by_accuracy(subject), force_accuracy(subject)});
  if (const auto* dipoles = subject.scene.effects.find<effects::InducedDipolesOptions>())
    for (const auto variant : {periodic::DipoleSum::ewald, periodic::DipoleSum::mixed_consistent,
                               periodic::DipoleSum::minimum_image, periodic::DipoleSum::source})
      if (variant != dipoles->sum) all.push_back(dipole_variant(subject, variant));
  return all;
}

/// Computes the reference with steps shorter than any of the sweep. The change at twice the step bounds its error.
void find_reference(GasSubject& subject, Diagram& diagram) {
  GasTrial best(subject, with(subject, Integrator::multirate, 0.08 / 128, 1280));
  GasTrial second(subject, with(subject, Integrator::multirate, 0.08 / 64, 640));
  best.run();
  subject.reference = best.positions();
  second.run();
  diagram.reference_errors = second.errors();
  diagram.reference = "multirate with 1280 steps in the shortest contact";
}

}  // namespace

void sweep_grains(const Scene& scene, const Request& request) {
  constexpr double horizon = 0.5;  // t0; a grain of a gas at T = 10 then has collided once or twice
  GasSubject subject{.scene = scene};
  subject.scene.stages.clear();
  subject.scene.mechanics.threads = 1;
  subject.scene.stop.time = std::min(scene.stop.time, horizon);
  choose(all_methods(subject), request);  // checks names before any computation
  Diagram diagram{
      .title = fmt::format("motion of {} grains over {:g} t0", scene.conductors.size(), subject.scene.stop.time),
      .quantities = {"places", "energy book"},
      .measure =
          "rms distance of grains from the reference, in d0; error of the energy balance over the sum of the "
          "final kinetic and the dissipated energy",
      .work = "steps of contacts",
      .clock = "time of one core"};
  request.begin();
  find_reference(subject, diagram);
  request.serve(diagram, choose(all_methods(subject), request));
}

}  // namespace lichtenberg::work_precision
