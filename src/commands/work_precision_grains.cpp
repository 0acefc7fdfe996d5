#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "solvers/error.hpp"
#include "src/commands/work_precision.hpp"
#include "src/granular/integrator.hpp"

namespace lichtenberg::work_precision {
namespace {

/// A gas of grains over a time so short that it is not chaotic yet.
struct GasSubject {
  Scene scene;
  std::vector<double> reference;  ///< d0, places at the end, across the box
};

/// Places that go on across the sides of the box.
std::vector<double> unwrapped(const Bodies& bodies) {
  std::vector<double> places = bodies.position;
  for (std::size_t k = 0; k < places.size(); ++k)
    places[k] += bodies.image[k] * bodies.box.lengths[static_cast<int>(k % bodies.dimension)];
  return places;
}

/// A run of it.
class GasTrial : public Trial {
 public:
  GasTrial(const GasSubject& subject, const MechanicsOptions& mechanics) : subject_(subject), scene_(subject.scene) {
    scene_.mechanics = mechanics;
  }

  void run() override {
    granular::Gas gas(scene_);
    const auto integrator = granular::make_integrator(scene_.mechanics.integrator);
    const double energy = gas.energy().total(), end = scene_.stop.time;
    while (gas.time() < end) {
      const double left = end - gas.time(), count = std::ceil(left / integrator->longest_step(gas));
      integrator->step(gas, count <= 1 ? end : gas.time() + left / count);
    }
    places_ = unwrapped(gas.bodies());
    const granular::GasEnergy book = gas.energy();
    left_over_ = std::abs(book.total() - energy) / (book.kinetic + book.dissipated);
    steps_ = gas.contact_steps;
  }
  std::vector<double> errors() const override {
    double squares = 0;
    for (std::size_t k = 0; k < places_.size(); ++k)
      squares += (places_[k] - subject_.reference[k]) * (places_[k] - subject_.reference[k]);
    const double grains = static_cast<double>(subject_.scene.conductors.size());
    return {std::sqrt(squares / grains), left_over_};
  }
  std::int64_t work() const override { return steps_; }
  const std::vector<double>& places() const { return places_; }

 private:
  const GasSubject& subject_;
  Scene scene_;
  std::vector<double> places_;
  double left_over_ = 0;
  std::int64_t steps_ = 0;
};

MechanicsOptions with(const GasSubject& subject, Integrator integrator, double step, int contact_steps = 30) {
  MechanicsOptions mechanics = subject.scene.mechanics;
  mechanics.integrator = integrator;
  mechanics.step = step;
  mechanics.contact_steps = contact_steps;
  return mechanics;
}

Candidate candidate(const GasSubject& subject, Settings settings, double cost, const MechanicsOptions& mechanics) {
  return {std::move(settings), cost, [&subject, mechanics] { return std::make_unique<GasTrial>(subject, mechanics); }};
}

/// Steps of charges and of contacts are made shorter together.
Method multirate(const GasSubject& subject) {
  Method method{"multirate", "charges held over a step, within which contacts have steps of their own", {}};
  for (int k = 0; k < 6; ++k) {
    const double step = 0.08 / (1 << k);
    const int contact_steps = 10 << k;
    method.candidates.push_back(candidate(subject, {{"step", step}, {"contact steps", contact_steps}}, 1 << k,
                                          with(subject, Integrator::multirate, step, contact_steps)));
  }
  return method;
}

Method fixed_steps(const GasSubject& subject, Integrator integrator, std::string description) {
  Method method{name_of(integrator), std::move(description), {}};
  for (int k = 0; k < 6; ++k) {
    const double step = 0.01 / (1 << k);
    method.candidates.push_back(candidate(subject, {{"step", step}}, 1 << k, with(subject, integrator, step)));
  }
  return method;
}

std::vector<Method> all_methods(const GasSubject& subject) {
  return {multirate(subject), fixed_steps(subject, Integrator::verlet, "velocity Verlet with predicted velocities"),
          fixed_steps(subject, Integrator::gear, "Gear's predictor and corrector of order 6"),
          fixed_steps(subject, Integrator::gear_printed, "the same with G 3.41's coefficients as printed")};
}

/// By steps a quarter of the shortest of the sweep; what twice as long ones change is more than their error.
void find_reference(GasSubject& subject, Diagram& diagram) {
  GasTrial best(subject, with(subject, Integrator::multirate, 0.08 / 128, 1280));
  GasTrial second(subject, with(subject, Integrator::multirate, 0.08 / 64, 640));
  best.run();
  subject.reference = best.places();
  second.run();
  diagram.reference_errors = second.errors();
  diagram.reference = "multirate with 1280 steps in the shortest contact";
}

}  // namespace

Diagram sweep_grains(const Scene& scene, const Request& request) {
  constexpr double horizon = 0.5;  // t0: a grain of a gas at T = 10 then has collided once or twice
  GasSubject subject{.scene = scene};
  subject.scene.stages.clear();
  subject.scene.stop.time = std::min(scene.stop.time, horizon);
  choose(all_methods(subject), request.methods);  // names are checked before anything is computed
  Diagram diagram{
      .title = fmt::format("motion of {} grains over {:g} t0", scene.conductors.size(), subject.scene.stop.time),
      .quantities = {"places", "energy book"},
      .measure =
          "root mean square distance of a grain from where it should be, in d0; what the energy book is "
          "off by over the kinetic energy at the start",
      .work = "steps of contacts"};
  if (request.progress) request.progress(0, 0, "reference", {});
  find_reference(subject, diagram);
  measure(choose(all_methods(subject), request.methods), request, diagram);
  return diagram;
}

}  // namespace lichtenberg::work_precision
