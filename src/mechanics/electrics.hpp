#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "src/effects/conductor_frame.hpp"
#include "src/effects/contact_discharge.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/mechanics/charging.hpp"
#include "src/mechanics/contact_events.hpp"
#include "src/mechanics/counters.hpp"
#include "src/mechanics/resistor_currents.hpp"
#include "src/model/checkpoint.hpp"
#include "src/model/model.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::mechanics {

/// Which solver a trial asks: the scene's, or the predictor on its coarser grid, which the field effect must then have.
enum class FieldGrid { whole, predictor };

/// How forces and charges go on from an instant: as they did, in no known way, or as they came there from what was
/// held.
enum class Rates { kept, forgotten, since_then };

/// A contact that has made one of two groups, and when it was due (s): before now, if it has waited for others; later,
/// if it came along with others, a little before its time.
struct Merger {
  effects::Contact contact;
  double due = 0;
};

/// Consequences of contacts that were made and lost.
struct Regrouping {
  bool merged = false;          ///< charges have moved, and the field is another
  std::vector<Merger> mergers;  ///< if so
};

/// Electrical state of a scene of conductors: contacts, groups, charges and field. `Charging` holds all of it that changes
/// in time. solve() returns a Trial and does not change the state; accept() commits a trial.
class Electrics {
 public:
  /// `field` and `discharge` are the model's; `discharge` is null if only wires connect. All must outlive this.
  Electrics(const Scene& scene, Model& model, effects::FloatingConductors& field,
            const effects::ContactDischarge* discharge, Counters& counters);
  Electrics(const Electrics&) = delete;  // the field effect looks at its Charging
  Electrics& operator=(const Electrics&) = delete;

  const Charging& now() const { return now_; }
  /// Restores the state `before`. The bodies, whose charges follow it, are the caller's to restore.
  void go_back(const Charging& before) { now_ = before; }
  /// Sets the field that acts on the bodies from now on.
  void hold(effects::HeldField held) { now_.held = std::move(held); }
  /// Sets it to the field that was accepted last, at `time` (s).
  void hold(double time, Rates rates);

  /// Contacts and groups of the first instant. Throws InputError for a short circuit.
  void connect();
  /// Solves the field where the bodies are, with the charges that they will have at `time`.
  Trial solve(double time, FieldGrid grid = FieldGrid::whole);
  /// Commits a trial: injects the charge until its instant and distributes all charges as its field does. Requires the
  /// positions and the state for which it was solved. Throws Failure with the message of
  /// ResistorCurrents::pressed_apart_in_potential.
  void accept(Trial trial) { accept(std::move(trial), false); }
  /// As accept(), at an instant without a solve, with extrapolated charges `by_field` (C). Not with resistors.
  void share(double time, std::span<const double> by_field);
  /// Makes and loses contacts where the bodies are now. If groups part, their members keep the charges that they have:
  /// these must be accepted or shared at this instant. If groups merge, charges move: solves, accepts and returns true.
  /// Groups that only part keep charges, potentials and so the field as it was accepted, and what is lost after a
  /// merger was due parts behind it. `due_since`: s, since when a contact may have been due. Throws Failure for a short
  /// circuit.
  Regrouping reconnect(double time, double due_since, FieldGrid grid = FieldGrid::whole);
  Regrouping reconnect(double time) { return reconnect(time, time); }

  effects::FloatingConductors& field() { return field_; }
  /// Series resistors and contacts that carry charge at a finite rate.
  const ResistorCurrents& resistors() const { return resistors_; }
  /// Whether conductors that come close are in contact, and what may happen to their contacts.
  bool has_contacts() const { return discharge_ != nullptr; }
  const ContactEvents& contact_events() const { return contact_events_; }
  /// Readings of every supply (supplies_of) at the instant of the last accepted solve.
  std::vector<TerminalReading> terminals() const;
  /// Null in a scene without a circuit.
  EnergyBook* energy() { return now_.energy ? &*now_.energy : nullptr; }
  /// Every group is held by an electrode, and no force or speed exceeds `fraction` of the largest (D 7.1).
  bool stationary(double fraction) const;

  void save(Checkpoint& checkpoint) const;
  /// `time`: that of the checkpoint. Throws Failure if it is of another scene.
  void restore(const Checkpoint& checkpoint, double time);

 private:
  effects::ContactDischarge::Changes look_at_contacts();
  bool keep(std::span<const effects::Contact> lost);
  void drop(std::span<const effects::Contact> lost);
  bool regroup(double time, FieldGrid grid);
  std::vector<Merger> mergers(std::span<const effects::Contact> made, double time, double due_since) const;
  std::vector<effects::Contact> lost_after(std::span<const Merger> mergers, std::span<const effects::Contact> lost,
                                           double time) const;
  std::pair<int, int> groups_of(effects::Contact contact) const;
  std::vector<double> currents(double time) const;
  void distribute(std::span<const double> fed, double dt, std::span<const double> by_node);
  void note_largest();
  void accept(Trial trial, bool merged);
  void book_energy(const Trial& trial, bool merged);
  double work_since_booking(double time) const;

  const Scene& scene_;
  Model& model_;
  Counters& counters_;
  effects::FloatingConductors& field_;
  const effects::ContactDischarge* discharge_;  ///< null: only wires connect
  ContactEvents contact_events_;
  std::vector<effects::Terminal> terminals_;
  std::vector<effects::Supply> supplies_;
  double relaxation_time_;  ///< s, of leakage
  ResistorCurrents resistors_;
  Charging now_;
};

}  // namespace lichtenberg::mechanics
