#include "src/mechanics/simulation.hpp"

#include <optional>

#include "solvers/error.hpp"
#include "src/effects/contact_discharge.hpp"
#include "src/effects/effects.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/mechanics/electrics.hpp"
#include "src/mechanics/stepper.hpp"
#include "src/model/checkpoint.hpp"

namespace lichtenberg {
namespace {

using Solver = std::unique_ptr<laplace::LaplaceSolver>;

/// Null, which means the default: the tolerance of a moving scene. Inside an integrator's error control the field's own
/// error must not show.
Solver default_solver(const Scene& scene) {
  const bool inside = scene.mechanics.integrator == "cvode" && scene.mechanics.coupling == "monolithic";
  return inside && scene.effects.has<effects::FloatingConductorsOptions>() ? effects::make_field_solver(scene.field)
                                                                           : nullptr;
}

/// The effects that the electrics must know; null where they are not in the scene.
struct Electric {
  std::unique_ptr<effects::FloatingConductors> field;
  std::unique_ptr<effects::ContactDischarge> discharge;
};

Electric make_electric(const Scene& scene, Solver solver) {
  Electric made;
  if (scene.effects.has<effects::ContactDischargeOptions>())
    made.discharge = std::make_unique<effects::ContactDischarge>(scene);
  if (!scene.effects.has<effects::FloatingConductorsOptions>()) return made;
  made.field = solver ? std::make_unique<effects::FloatingConductors>(scene, std::move(solver))
                      : effects::make_floating_conductors(scene);
  return made;
}

}  // namespace

struct Simulation::Implementation {
  Implementation(const Scene& s, Solver solver) : Implementation(s, make_electric(s, std::move(solver))) {}
  Implementation(const Scene& s, Electric electric);
  void begin();
  void save_counters(Checkpoint& checkpoint) const;
  void restore_counters(const Checkpoint& checkpoint);

  Scene scene;
  effects::FloatingConductors* field;    ///< the model's; null in a neutral scene
  effects::ContactDischarge* discharge;  ///< the model's; null if there is none
  Model model;
  Counters counters;
  std::optional<mechanics::Electrics> electrics;  ///< empty in a neutral scene
  std::unique_ptr<mechanics::Stepper> stepper;
  double time = 0;
  bool connected = false;  ///< contacts and groups are known
  bool begun = false;      ///< the field of this instant is known
};

Simulation::Implementation::Implementation(const Scene& s, Electric electric)
    : scene(s),
      field(electric.field.get()),
      discharge(electric.discharge.get()),
      model(effects::make_model(scene, effects::made(std::move(electric.field), std::move(electric.discharge)))) {
  if (field) electrics.emplace(scene, model, *field, discharge, counters);
  stepper = mechanics::make_stepper({scene, model, electrics ? &*electrics : nullptr, counters});
}

void Simulation::Implementation::begin() {
  if (begun) return;
  if (electrics) {
    if (!connected) electrics->connect();
    electrics->solve(time);
    electrics->settle(time);
  }
  stepper->begin(time);
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
const std::vector<effects::Contact>* Simulation::contacts() const {
  return implementation_->discharge ? &implementation_->discharge->contacts() : nullptr;
}
const laplace::LaplaceProblem* Simulation::last_problem() const {
  const effects::FloatingConductors* field = implementation_->field;
  return field && field->last_problem() ? &*field->last_problem() : nullptr;
}

void Simulation::advance_to(double time) {
  Implementation& self = *implementation_;
  self.begin();
  if (time <= self.time) return;
  self.stepper->advance(self.time, time);
  self.time = time;
}

Frame Simulation::frame() {
  Implementation& self = *implementation_;
  self.begin();
  Frame frame;
  frame.time = self.time;
  for (int i = 0; i < self.model.bodies.size(); ++i) {
    frame.position.push_back(position(self.model.bodies, i));
    frame.velocity.push_back(velocity(self.model.bodies, i));
  }
  if (!self.electrics) return frame;
  const effects::Electrostatics& field = self.electrics->last();
  const effects::ElectricalGroups& groups = self.electrics->groups();
  const effects::ChargeLedger& ledger = self.electrics->ledger();
  frame.force = field.force;
  frame.charge = self.model.bodies.charge;
  frame.potential = field.potential;
  frame.group = groups.connected;
  frame.energy = field.energy;
  frame.charge_held = ledger.held();
  frame.charge_fed = ledger.fed();
  frame.charge_drained = ledger.drained();
  frame.charge_leaked = ledger.leaked();
  if (const mechanics::EnergyBook* energy = self.electrics->energy())
    frame.energy_balance = {self.model.kinetic_energy(), self.model.stored_energy(self.time), energy->flows()};
  frame.terminals = self.electrics->terminals();
  frame.field_solves = self.counters.field_solves;
  frame.iterations = self.counters.iterations;
  return frame;
}

laplace::Field Simulation::field() {
  Implementation& self = *implementation_;
  if (!self.electrics) throw Failure("there is no field in a scene without the table [effects.floating_conductors]");
  self.begin();
  return self.electrics->field().solver().field();
}

bool Simulation::stationary() {
  Implementation& self = *implementation_;
  if (!self.electrics) return false;
  self.begin();
  return self.electrics->stationary(self.scene.stop.force);
}

Checkpoint Simulation::checkpoint() {
  Implementation& self = *implementation_;
  const Checkpoint checkpoint = snapshot();
  if (self.electrics) self.electrics->field().forget();
  self.begun = false;
  return checkpoint;
}

Checkpoint Simulation::snapshot() {
  Implementation& self = *implementation_;
  self.begin();
  Checkpoint checkpoint;
  checkpoint.reals["time"] = {self.time};
  checkpoint.reals["position"] = self.model.bodies.position;
  checkpoint.reals["momentum"] = self.model.bodies.momentum;
  self.save_counters(checkpoint);
  if (self.electrics) self.electrics->save(checkpoint);
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
  self.restore_counters(checkpoint);
  if (self.electrics) {
    self.electrics->restore(checkpoint, self.time);
    self.electrics->field().forget();
  }
  self.stepper->restore(checkpoint);
  self.model.restore(checkpoint);
  self.connected = true;
  self.begun = false;
}

}  // namespace lichtenberg
