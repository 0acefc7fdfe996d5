#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "src/effects/conductor_frame.hpp"
#include "src/effects/contact_discharge.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/mechanics/contact_events.hpp"
#include "src/mechanics/counters.hpp"
#include "src/mechanics/electrical_state.hpp"
#include "src/mechanics/resistor_currents.hpp"
#include "src/model/checkpoint.hpp"
#include "src/model/model.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::mechanics {

/// Solver of a field solve: `whole` is the scene's own. `predictor` is the approximate solver on a coarser grid, which
/// the field effect must then have.
enum class FieldGrid { whole, predictor };

/// Rates of forces (N/s) and charges (A) for the extrapolation in time from a field solve on. `kept`: the present
/// rates; `forgotten`: zero; `difference_quotient`: from the previous and the accepted field.
enum class Rates { kept, forgotten, difference_quotient };

/// Group merge: a contact that has joined two equipotential groups, and the time (s) at which it was due. That time is
/// past if the merge has waited for others, so that they share one field solve. It is ahead if the merge comes a little
/// early for the same reason.
struct Merger {
  effects::Contact contact;
  double due = 0;
};

/// Result of an update of the contacts: the merges of equipotential groups.
struct Regrouping {
  bool merged = false;          ///< groups have merged, charges have moved, and the field was solved again
  std::vector<Merger> mergers;  ///< empty unless `merged`
};

/// Electrical part of a scene of conductors: contacts, equipotential groups, charges and field, and their changes in
/// time. All of them are in one ElectricalState. solve() returns a Trial and does not change this state; accept()
/// commits the trial.
class Electrics {
 public:
  /// Makes the electrical state of the first instant, without contacts or a field yet. `field` and `discharge` are
  /// effects of the model; `discharge` is null if only wires connect conductors. All arguments must outlive this
  /// object.
  Electrics(const Scene& scene, Model& model, effects::FloatingConductors& field,
            const effects::ContactDischarge* discharge, Counters& counters);
  Electrics(const Electrics&) = delete;  // the field effect refers to now_
  Electrics& operator=(const Electrics&) = delete;

  const ElectricalState& now() const { return now_; }
  /// Restores the state `before`. The caller restores the bodies, and with them their charges.
  void rollback(const ElectricalState& before) { now_ = before; }
  /// Sets the electric forces and charges, extrapolated linearly in time, that act on the bodies.
  void set_extrapolation(effects::ExtrapolatedField extrapolated) { now_.extrapolated = std::move(extrapolated); }
  /// Extrapolates forces and charges from the last accepted field, which is that of `time` (s), with these rates.
  void set_extrapolation(double time, Rates rates);

  /// Finds the electrical contacts and equipotential groups of the first instant. Throws InputError for a short
  /// circuit.
  void connect();
  /// Solves the field at the present positions of the bodies, with the charges advanced to `time` (s). Returns a trial;
  /// now() does not change. Throws Failure if two bodies touch at different prescribed potentials. Throws Failure, or
  /// InputError at the first solve, if the field cannot be solved.
  Trial solve(double time, FieldGrid grid = FieldGrid::whole);
  /// Commits a trial: injects the charge up to its instant, and divides the charge of each equipotential group as its
  /// field does. Requires the positions and the state for which it was solved. Throws Failure if conductors touch at
  /// different potentials (ResistorCurrents::unequal_contact_message).
  void accept(Trial trial) { accept(std::move(trial), false); }
  /// Advances the charges to `time` (s) without a field solve: injects charge as accept() does, and divides each
  /// equipotential group's charge by the extrapolated charges `by_field` (C, by conductor). Not allowed with resistors.
  void accept_extrapolated(double time, std::span<const double> by_field);
  /// Closes and opens contacts for the present positions, and updates the equipotential groups. Returns the group
  /// merges. Charges must be accepted at this `time` (s). Members of groups that split keep their charges and
  /// potentials, so that the accepted field stays valid. If groups merge, charges move: the function solves and accepts
  /// the new field on `grid`. A contact that opened after a merge was due splits its group after the merge.
  /// `due_since`: earliest time (s) at which a contact may have been due. Throws Failure for a short circuit.
  Regrouping reconnect(double time, double due_since, FieldGrid grid = FieldGrid::whole);
  /// Closes and opens contacts and updates the groups by reconnect(time, time): all changes are due at `time` (s).
  Regrouping reconnect(double time) { return reconnect(time, time); }

  /// Returns the first time (s) after `time` at which the potential or the current of a source, or its slope, jumps;
  /// infinite without such sources. No step may pass it.
  double next_corner(double time) const;
  /// Passes a corner of a source at the time of the last accepted solve: if a potential jumps there, solves and accepts
  /// the field after the jump. Returns true if `time` (s) is a corner to within `rounding` (s).
  bool pass_corner(double time, double rounding);

  effects::FloatingConductors& field() { return field_; }
  /// Returns the currents of series resistors and of contacts that carry charge at a finite rate.
  const ResistorCurrents& resistors() const { return resistors_; }
  /// Returns true if close conductors make contacts (effect contact_discharge).
  bool has_contacts() const { return discharge_ != nullptr; }
  /// Returns true if electrodes, sides or groups have nodes of their own (circuit_nodes()).
  bool has_circuits() const { return !circuits_.empty(); }
  const ContactEvents& contact_events() const { return contact_events_; }
  /// Returns the readings of every potential source (electrode, electrode side, or wire at a prescribed potential) at
  /// the last accepted solve: potential and collected charge. In a scene with a circuit they include surface potential
  /// and delivered charge.
  std::vector<TerminalReading> terminals() const;
  /// Returns the energy balance; null in a scene without a circuit.
  EnergyBudget* energy() { return now_.energy ? &*now_.energy : nullptr; }
  /// Returns true if contacts and wires connect every conductor to a prescribed potential (electrode, side or wire),
  /// and all free conductors are nearly at rest. The force on each and its speed are then at most `fraction` of the
  /// largest of the run (D 7.1). False while sources still vary.
  bool stationary(double fraction) const;

  /// Saves charges, contacts, resistor currents, the energy balance, and the largest force and speed.
  void save(Checkpoint& checkpoint) const;
  /// Restores the electrical state of a checkpoint made at `time` (s). Throws Failure if the checkpoint's arrays do not
  /// fit the scene.
  void restore(const Checkpoint& checkpoint, double time);

 private:
  effects::ContactDischarge::Changes detect_contact_events();
  bool restore_contacts(std::span<const effects::Contact> lost);
  void remove_contacts(std::span<const effects::Contact> lost);
  bool regroup(double time, FieldGrid grid);
  std::vector<Merger> mergers(std::span<const effects::Contact> made, double time, double due_since) const;
  std::vector<effects::Contact> lost_after(std::span<const Merger> mergers, std::span<const effects::Contact> lost,
                                           double time) const;
  std::pair<int, int> groups_of(effects::Contact contact) const;
  std::vector<double> currents(double time) const;
  void distribute(std::span<const double> injected_current, double dt, std::span<const double> by_node);
  void update_largest();
  void accept(Trial trial, bool merged);
  void record_energy(const Trial& trial, bool merged);
  double work_since_record(double time) const;

  const Scene& scene_;
  Model& model_;
  Counters& counters_;
  effects::FloatingConductors& field_;
  const effects::ContactDischarge* discharge_;  ///< null: only wires connect conductors
  ContactEvents contact_events_;
  std::vector<effects::Terminal> terminals_;
  std::vector<effects::PotentialSource> supplies_;
  std::vector<effects::CircuitNode> circuits_;
  std::vector<double> capacitance_;  ///< F, by circuit node; empty without capacitors
  std::vector<Signal> signals_;      ///< functions of time of sources
  double relaxation_time_;           ///< s, of leakage
  ResistorCurrents resistors_;
  ElectricalState now_;
};

}  // namespace lichtenberg::mechanics
