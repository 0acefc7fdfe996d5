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

/// Solver of a trial: the scene's own, or the predictor on its coarser grid, which the field effect must then have.
enum class FieldGrid { whole, predictor };

/// Rates of forces and charges from an instant on: the rates of before, zero, or the difference quotient from the
/// previous field to the accepted one.
enum class Rates { kept, forgotten, difference_quotient };

/// Contact that has joined two groups, and the time (s) at which it was due. That time is past if the merge has waited
/// for others, and ahead if it shares a solve with others a little before its time.
struct Merger {
  effects::Contact contact;
  double due = 0;
};

/// Result of a change of contacts.
struct Regrouping {
  bool merged = false;          ///< true: groups have merged, charges have moved, and the field was solved again
  std::vector<Merger> mergers;  ///< empty unless `merged`
};

/// Electrical state of a scene of conductors: contacts, groups, charges and field. `ElectricalState` holds all of it
/// that changes in time. solve() returns a Trial and does not change the state; accept() commits a trial.
class Electrics {
 public:
  /// `field` and `discharge` belong to the model; `discharge` is null if only wires connect conductors. All arguments
  /// must outlive this object.
  Electrics(const Scene& scene, Model& model, effects::FloatingConductors& field,
            const effects::ContactDischarge* discharge, Counters& counters);
  Electrics(const Electrics&) = delete;  // the field effect refers to now_
  Electrics& operator=(const Electrics&) = delete;

  const ElectricalState& now() const { return now_; }
  /// Restores the state `before`. The caller restores the bodies, and with them their charges.
  void rollback(const ElectricalState& before) { now_ = before; }
  /// Sets the field that acts on the bodies.
  void set_extrapolation(effects::ExtrapolatedField extrapolated) { now_.extrapolated = std::move(extrapolated); }
  /// Sets the field that acts on the bodies to the last accepted field, with its origin at `time` (s).
  void set_extrapolation(double time, Rates rates);

  /// Finds the contacts and groups of the first instant. Throws InputError for a short circuit.
  void connect();
  /// Solves the field at the present positions, with the charges at `time` (s).
  Trial solve(double time, FieldGrid grid = FieldGrid::whole);
  /// Commits a trial: injects the charge until its instant and distributes all charges as its field does. Requires the
  /// positions and the state for which it was solved. Throws Failure with the message of
  /// ResistorCurrents::unequal_contact_message.
  void accept(Trial trial) { accept(std::move(trial), false); }
  /// Injects and distributes charges as accept() does, at an instant without a solve, with extrapolated charges
  /// `by_field` (C). Not with resistors.
  void accept_extrapolated(double time, std::span<const double> by_field);
  /// Updates contacts and groups for the present positions. Charges must be accepted or shared at this instant. Members
  /// of groups that split keep their charges and potentials, so that the accepted field stays valid. If groups merge,
  /// charges move: the function solves and accepts the new field. A contact that was lost after a merge was due splits
  /// its group after the merge. `due_since`: earliest time (s) at which a contact may have been due. Throws Failure for
  /// a short circuit.
  Regrouping reconnect(double time, double due_since, FieldGrid grid = FieldGrid::whole);
  Regrouping reconnect(double time) { return reconnect(time, time); }

  effects::FloatingConductors& field() { return field_; }
  /// Series resistors and contacts that carry charge at a finite rate.
  const ResistorCurrents& resistors() const { return resistors_; }
  /// True if close conductors make contacts.
  bool has_contacts() const { return discharge_ != nullptr; }
  const ContactEvents& contact_events() const { return contact_events_; }
  /// Returns the readings of every source (potential_sources_of) at the instant of the last accepted solve.
  std::vector<TerminalReading> terminals() const;
  /// Null in a scene without a circuit.
  EnergyBudget* energy() { return now_.energy ? &*now_.energy : nullptr; }
  /// Returns true if every conductor is connected with an electrode, and no force or speed exceeds `fraction` of the
  /// largest of the run (D 7.1).
  bool stationary(double fraction) const;

  void save(Checkpoint& checkpoint) const;
  /// Restores the electrical state. `time`: s, of the checkpoint. Throws Failure for a checkpoint of another scene.
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
  double relaxation_time_;  ///< s, of leakage
  ResistorCurrents resistors_;
  ElectricalState now_;
};

}  // namespace lichtenberg::mechanics
