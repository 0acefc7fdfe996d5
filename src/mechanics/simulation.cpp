#include "src/mechanics/simulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <thread>

#include "solvers/error.hpp"
#include "solvers/parallel/petsc.hpp"
#include "src/analysis/circuit.hpp"
#include "src/analysis/network.hpp"
#include "src/effects/contact_discharge.hpp"
#include "src/effects/effects.hpp"
#include "src/effects/field_choice.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/mechanics/electrics.hpp"
#include "src/mechanics/step_check.hpp"
#include "src/mechanics/stepper.hpp"
#include "src/mechanics/summary.hpp"
#include "src/model/checkpoint.hpp"

namespace lichtenberg {
namespace {

using Solver = std::unique_ptr<laplace::LaplaceSolver>;

/// Returns the field solver of a scene whose field is inside the integrator's error control, where the field's error
/// must be negligible. Otherwise null: the default, with the tolerance of a moving scene.
Solver default_solver(const Scene& scene) {
  return effects::is_inside_integrator(scene) && scene.dimension() == 2 &&
                 scene.effects.has<effects::FloatingConductorsOptions>()
             ? effects::make_field_solver(scene.field())
             : nullptr;
}

Model make_model(const Scene& scene, Solver solver) {
  if (!solver || !scene.effects.has<effects::FloatingConductorsOptions>()) return effects::make_model(scene);
  return effects::make_model(scene,
                             effects::made(std::make_unique<effects::FloatingConductors>(scene, std::move(solver))));
}

/// Returns the model's effect of a class; null: none.
template <class E>
E* find(const Model& model) {
  for (const auto& effect : model.effects)
    if (auto* const found = dynamic_cast<E*>(effect.get())) return found;
  return nullptr;
}

/// Number of bodies for each worker thread. The work on this number of bodies at an event takes ten times as long as
/// the wake-up of a thread.
constexpr int bodies_per_thread = 4096;

/// Returns the rounding error (s) of a time that steps or frames add up.
double rounding_of_time(double time) { return 1e-14 * std::abs(time); }

int team_size(const Scene& scene) {
  const int requested_threads = scene.effects.has<effects::FloatingConductorsOptions>() ? scene.field().threads : 0;
  const int available = parallel::process_count() > 1 ? 1 : static_cast<int>(std::thread::hardware_concurrency());
  const int cores = requested_threads > 0 ? requested_threads : available;
  return std::clamp(1 + static_cast<int>(scene.conductors.size()) / bodies_per_thread, 1, std::max(cores, 1));
}

}  // namespace

struct Simulation::Implementation {
  Implementation(const Scene& s, Solver solver);
  void begin();
  void advance(double end);
  ConductorFrame now();
  Frame motion() const;
  void add_image(Frame& frame) const;
  std::optional<analysis::ContactNetwork> network(std::span<const Vec3> position) const;
  mechanics::Outcome outcome(bool stationary);
  void save_counters(Checkpoint& checkpoint) const;
  void restore_counters(const Checkpoint& checkpoint);

  Scene scene;
  parallel::Team team;
  Model model;
  Counters counters;
  std::optional<mechanics::Electrics> electrics;  ///< empty in a neutral scene
  std::unique_ptr<mechanics::Stepper> stepper;
  std::optional<mechanics::StepCheck> check;  ///< of the steps of `stepper`
  double time = 0;
  bool connected = false;  ///< contacts and groups are known
  bool begun = false;      ///< the field of this instant is known
  // For a scene with a circuit:
  std::optional<ConductorFrame> before;  ///< state at the start of the last advance
  double energy_at_start = 0;            ///< J, analysis::energy_account
  // For a scene with field.accuracy:
  std::optional<double> largest_error;  ///< of the field, estimated by warnings()
  double checking_seconds = 0;
  double largest_overlap = 0;   ///< of all frames
  std::function<bool()> pause;  ///< set while the simulation advances
};

Simulation::Implementation::Implementation(const Scene& s, Solver solver)
    : scene(s), team(team_size(scene)), model(make_model(scene, std::move(solver))) {
  model.team = &team;
  if (auto* const field = find<effects::FloatingConductors>(model))
    electrics.emplace(scene, model, *field, find<effects::ContactDischarge>(model), counters);
  const auto between_steps = [this] {
    check->between_steps();
    if (pause && pause()) throw Paused();
  };
  const auto commit = [this](double end, double dt) {
    wrap(model.bodies);
    model.accept(end, dt);
    check->commit(dt);
  };
  stepper = mechanics::make_stepper({scene, model, electrics ? &*electrics : nullptr, counters, between_steps, commit});
  check.emplace(model, std::string(scene.mechanics.kind().name), !stepper->limits_moves());
}

void Simulation::Implementation::begin() {
  if (begun) return;
  const Stopwatch watch(counters.all_seconds);
  if (electrics) {
    if (!connected) electrics->connect();
    electrics->accept(electrics->solve(time));
  }
  stepper->begin(time);
  if (!connected && electrics && electrics->energy()) energy_at_start = analysis::energy_account(now());
  connected = begun = true;
}

void Simulation::Implementation::save_counters(Checkpoint& checkpoint) const {
  const Counters& c = counters;
  checkpoint.integers["counters"] = {c.field_solves,   c.iterations,  c.predictions,          c.steps,
                                     c.rejected_steps, c.corrections, c.rejected_corrections, c.contacts_made,
                                     c.contacts_lost,  c.regroupings};
}

void Simulation::Implementation::restore_counters(const Checkpoint& checkpoint) {
  const std::vector<std::int64_t>& saved = integers(checkpoint, "counters");
  Counters& c = counters;
  const auto all = {&c.field_solves, &c.iterations,           &c.predictions,   &c.steps,         &c.rejected_steps,
                    &c.corrections,  &c.rejected_corrections, &c.contacts_made, &c.contacts_lost, &c.regroupings};
  if (saved.size() != all.size())
    throw Failure("the checkpoint's counters are not those of this program: another version of it wrote them");
  auto from = saved.begin();
  for (std::int64_t* counter : all) *counter = *from++;
}

Simulation::Simulation(const Scene& scene) : Simulation(scene, default_solver(scene)) {}
Simulation::Simulation(const Scene& scene, std::unique_ptr<laplace::LaplaceSolver> solver)
    : implementation_(std::make_unique<Implementation>(scene, std::move(solver))) {}
Simulation::~Simulation() = default;

double Simulation::time() const { return implementation_->time; }
const Counters& Simulation::counters() const { return implementation_->counters; }
const Model& Simulation::model() const { return implementation_->model; }

void Simulation::advance_to(double time, const std::function<bool()>& pause) {
  Implementation& self = *implementation_;
  self.pause = pause;
  self.begin();
  if (time <= self.time) return;
  if (self.electrics && self.electrics->energy()) self.before = now();
  self.advance(time);
  self.time = time;
}

/// Advances to `end`. The force between touching conductors at different potentials has no limit; the failure then
/// names these conductors instead of the overloaded contact.
void Simulation::Implementation::advance(double end) {
  const Stopwatch watch(counters.all_seconds);
  try {
    for (double from = time; from < end;) {
      const double corner = electrics ? electrics->next_corner(from) : INFINITY;
      const double to = corner < end - rounding_of_time(end) ? corner : end;
      check->begin();
      stepper->advance(from, to);
      check->end(from, to);
      if (electrics) {
        const std::vector<Vec3> force_before = electrics->now().field.force;
        if (electrics->pass_corner(to, rounding_of_time(to))) stepper->pass_corner(to, force_before);
      }
      from = to;
    }
  } catch (const Failure& failure) {
    const std::string cause = electrics ? electrics->resistors().unequal_contact_message() : "";
    if (cause.empty()) throw;
    throw Failure(cause);
  }
}

double Simulation::next_frame() const {
  // Times of frames are multiples of `every` up to rounding. For example, 11 * 0.03 rounds below 0.33 and is not
  // a frame before an end at 0.33.
  constexpr double rounding = 1e-9;
  const double every = implementation_->scene.output.every, stop = end_time();
  const double next = every * (std::floor(time() / every + rounding) + 1);
  return next < stop - rounding * every ? next : stop;
}

double Simulation::end_time() const { return implementation_->scene.stop.time; }

bool Simulation::finished() { return time() >= end_time() || (implementation_->scene.stop.stationary && stationary()); }

ConductorFrame Simulation::now() {
  Implementation& self = *implementation_;
  self.begin();
  return self.now();
}

ConductorFrame Simulation::Implementation::now() {
  ConductorFrame frame{.time = time};
  for (int i = 0; i < model.bodies.size(); ++i) {
    frame.position.push_back(position_in_space(model.bodies, i));
    frame.velocity.push_back(velocity_in_space(model.bodies, i));
  }
  if (!electrics) return frame;
  const effects::Electrostatics& field = electrics->now().field;
  const effects::Charges& charges = electrics->now().charges;
  frame.force = field.force;
  frame.charge = model.bodies.charge;
  frame.potential = field.potential;
  frame.group = electrics->now().groups.connected;
  frame.energy = field.energy;
  frame.charge_held = charges.stored();
  frame.charge_fed = charges.injected();
  frame.charge_drained = charges.collected();
  frame.charge_leaked = charges.leaked();
  frame.terminals = electrics->terminals();
  if (const mechanics::EnergyBudget* energy = electrics->energy()) {
    frame.energy_balance = {model.kinetic_energy(), model.stored_energy(time), energy->flows()};
    if (before) frame.rates = analysis::circuit_rates(*before, frame, scene.medium.temperature);
  }
  frame.field_solves = counters.field_solves;
  frame.iterations = counters.iterations;
  return frame;
}

namespace {

/// Returns periodic images by body, [N * 3]; in the plane the third number is 0.
std::vector<std::int32_t> image_counts(const std::vector<int>& image, int dimension) {
  std::vector<std::int32_t> counts;
  for (std::size_t i = 0; i < image.size(); i += dimension)
    for (int k = 0; k < 3; ++k) counts.push_back(k < dimension ? image[i + k] : 0);
  return counts;
}

}  // namespace

/// Returns the frame of a neutral scene.
Frame Simulation::Implementation::motion() const {
  const Bodies& bodies = model.bodies;
  std::vector<double> velocity;
  for (std::size_t k = 0; k < bodies.momentum.size(); ++k)
    velocity.push_back(bodies.momentum[k] / bodies.mass[k / bodies.dimension]);
  Frame frame{.time = time};
  frame.add_vectors("position", "m", bodies.position, bodies.dimension);
  frame.add_vectors("velocity", "m s-1", velocity, bodies.dimension);
  add_image(frame);
  return frame;
}

void Simulation::Implementation::add_image(Frame& frame) const {
  const Bodies& bodies = model.bodies;
  if (!bodies.image.empty()) frame.add_particles("image", "1", image_counts(bodies.image, bodies.dimension), 3);
}

std::optional<analysis::ContactNetwork> Simulation::Implementation::network(std::span<const Vec3> position) const {
  if (!electrics || !electrics->has_contacts()) return {};
  std::vector<analysis::Edge> contacts;
  for (const auto& [conductor, partner] : electrics->now().contacts)
    contacts.emplace_back(conductor, partner < static_cast<int>(position.size()) ? partner : analysis::to_ground);
  return analysis::network(std::move(contacts), position);
}

Frame Simulation::frame() {
  Implementation& self = *implementation_;
  self.begin();
  self.largest_overlap = std::max(self.largest_overlap, mechanics::largest_overlap(self.scene, self.model.bodies));
  Frame frame = self.motion();
  if (self.electrics) {
    const ConductorFrame state = self.now();
    frame = columns_of(state);
    self.add_image(frame);
    if (const std::optional<analysis::ContactNetwork> network = self.network(state.position))
      analysis::add_columns(*network, frame);
  }
  self.model.add_columns(time(), frame);
  return frame;
}

std::optional<laplace::Field> Simulation::field() {
  Implementation& self = *implementation_;
  if (!self.electrics) return {};
  self.begin();
  laplace::LaplaceSolver* const solver = self.electrics->field().solver();
  return solver ? std::optional(solver->field()) : std::nullopt;
}

bool Simulation::stationary() {
  Implementation& self = *implementation_;
  if (!self.electrics) return false;
  self.begin();
  return self.electrics->stationary(self.scene.stop.force);
}

std::vector<effects::Contact> Simulation::contacts() const {
  const Implementation& self = *implementation_;
  return self.electrics ? self.electrics->now().contacts : std::vector<effects::Contact>{};
}

std::string Simulation::progress() {
  implementation_->begin();
  const ConductorFrame frame = implementation_->now();
  std::string text = fmt::format("t = {:.4g} of {:.4g} s", frame.time, end_time());
  if (frame.field_solves > 0)
    text += fmt::format(", {} field solves, {} iterations", frame.field_solves, frame.iterations);
  if (const std::optional<analysis::ContactNetwork> network = implementation_->network(frame.position))
    text += fmt::format(", {} of {} connected", network->degrees.connected, frame.position.size());
  return text;
}

std::vector<std::string> Simulation::warnings() {
  Implementation& self = *implementation_;
  if (!self.electrics || !self.electrics->field().last_problem()) return {};
  const Stopwatch stopwatch(self.checking_seconds);
  const double requested = self.scene.field_accuracy()->requested;
  const double estimate = effects::estimated_error(self.scene.field(), *self.electrics->field().last_problem());
  const bool first = estimate > requested && self.largest_error.value_or(0) <= requested;
  self.largest_error = std::max(self.largest_error.value_or(0), estimate);
  if (!first) return {};
  return {fmt::format("at t = {:.6g} s the field's error is estimated at {:.1e}, more than field.accuracy = {:g}",
                      self.time, estimate, requested)};
}

mechanics::Outcome Simulation::Implementation::outcome(bool stationary) {
  const std::vector<double> charge = effects::initial_node_charges(scene);
  mechanics::Outcome result{.frame = now(),
                            .network = {},
                            .stationary = stationary,
                            .initial_charge = std::accumulate(charge.begin(), charge.end(), 0.0),
                            .initial_energy = energy_at_start,
                            .largest_error = largest_error,
                            .largest_overlap = largest_overlap,
                            .counters = counters};
  result.network = network(result.frame.position);
  return result;
}

Summary Simulation::summary() {
  const bool at_rest = implementation_->scene.stop.stationary && stationary();
  Summary summary = mechanics::summarize(implementation_->scene, implementation_->outcome(at_rest));
  implementation_->model.summarize(time(), summary);
  return summary;
}

std::map<std::string, double> Simulation::seconds() const {
  const Implementation& self = *implementation_;
  std::map<std::string, double> all{{"field", self.counters.field_seconds},
                                    {"mechanics", self.counters.mechanics_seconds},
                                    {"contacts", self.counters.contact_seconds}};
  // The rest is charges, error control and corrections, so that all parts add up to the whole.
  if (self.electrics) {
    double rest = self.counters.all_seconds;
    for (const auto& [part, seconds] : all) rest -= seconds;
    all["coupling"] = std::max(rest, 0.0);
  }
  if (self.scene.field_accuracy()) all["accuracy"] = self.checking_seconds;
  return all;
}

Checkpoint Simulation::checkpoint() {
  Implementation& self = *implementation_;
  const Checkpoint checkpoint = *snapshot();
  if (self.electrics) self.electrics->field().forget();
  self.begun = false;
  return checkpoint;
}

std::optional<Checkpoint> Simulation::snapshot() {
  Implementation& self = *implementation_;
  self.begin();
  Checkpoint checkpoint;
  checkpoint.reals["time"] = {self.time};
  checkpoint.reals["position"] = self.model.bodies.position;
  checkpoint.reals["momentum"] = self.model.bodies.momentum;
  const std::vector<int>& image = self.model.bodies.image;
  if (!image.empty()) checkpoint.integers["image"].assign(image.begin(), image.end());
  self.save_counters(checkpoint);
  if (self.electrics) self.electrics->save(checkpoint);
  if (self.electrics && self.electrics->energy()) checkpoint.reals["energy_at_start"] = {self.energy_at_start};
  if (self.largest_error) checkpoint.reals["largest_field_error"] = {*self.largest_error};
  if (self.largest_overlap > 0) checkpoint.reals["largest_overlap"] = {self.largest_overlap};
  self.stepper->save(checkpoint);
  self.model.save(checkpoint);
  return checkpoint;
}

void Simulation::restore(const Checkpoint& checkpoint) {
  Implementation& self = *implementation_;
  Bodies& bodies = self.model.bodies;
  const std::size_t components = bodies.position.size();
  self.time = reals(checkpoint, "time", 1).front();
  bodies.position = reals(checkpoint, "position", components);
  bodies.momentum = reals(checkpoint, "momentum", components);
  if (!bodies.image.empty()) {
    const std::vector<std::int64_t>& image = integers(checkpoint, "image");
    if (image.size() != components)
      throw Failure("the checkpoint's image numbers are not those of this scene: another version of it wrote them");
    bodies.image.assign(image.begin(), image.end());
  }
  self.restore_counters(checkpoint);
  if (self.electrics) {
    self.electrics->restore(checkpoint, self.time);
    self.electrics->field().forget();
    if (self.electrics->energy()) self.energy_at_start = reals(checkpoint, "energy_at_start", 1).front();
  }
  if (checkpoint.reals.contains("largest_field_error"))
    self.largest_error = reals(checkpoint, "largest_field_error", 1).front();
  if (checkpoint.reals.contains("largest_overlap"))
    self.largest_overlap = reals(checkpoint, "largest_overlap", 1).front();
  self.stepper->restore(checkpoint);
  self.model.restore(checkpoint);
  self.connected = true;
  self.begun = false;
}

}  // namespace lichtenberg
