#pragma once

#include <vector>

#include "src/effects/charge_ledger.hpp"
#include "src/effects/contact_discharge.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/mechanics/counters.hpp"
#include "src/mechanics/cvode.hpp"
#include "src/model/frame.hpp"
#include "src/model/model.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::mechanics {

/// The electric half of a conductor scene: who is connected with whom, who holds which charge, what the field does.
/// Steppers call it in this order: solve (as often as they try), settle (once a step is accepted), reconnect.
class Electrics {
 public:
  /// The model must have floating_conductors; scene, model and counters must outlive this.
  Electrics(const Scene& scene, Model& model, Counters& counters);

  /// Contacts and groups of the first instant. Throws InputError for a short circuit.
  void connect();
  /// Gives the bodies the charges of `time` and solves the field. Changes nothing else: a step can still be taken back.
  const effects::Electrostatics& solve(double time);
  /// Books the charges fed until `time`, the instant of the last solve, and shares them as that field does.
  void settle(double time);
  /// The same at an instant without a solve, with charges `by_field` (C) that are known otherwise.
  void share(double time, std::span<const double> by_field);
  /// Makes and loses contacts where the bodies are now. If groups part, their members keep the charges that they have:
  /// these must be settled or shared at this instant. If groups merge, charges move: solves and settles again and
  /// returns true. Groups that only part keep charges, potentials and so the field as it was settled: returns false.
  /// Throws Failure for a short circuit.
  bool reconnect(double time);

  /// Contacts that may change while body i moves by travel[i] (m), as events, and one event more, the last, for the
  /// first body that moves farther: what elastic contacts do to it is not known beforehand. Empty without
  /// contact_discharge.
  Events events(std::span<const double> travel) const;

  const effects::Electrostatics& last() const { return field_.last(); }
  effects::FloatingConductors& field() { return field_; }
  const effects::ElectricalGroups& groups() const { return groups_; }
  const effects::ChargeLedger& ledger() const { return ledger_; }
  std::vector<TerminalReading> terminals() const;
  /// Largest force (N) and speed (m/s) of a body at any instant that was settled.
  double largest_force() const { return largest_force_; }
  double largest_speed() const { return largest_speed_; }
  /// Every group is held by an electrode, and no force or speed exceeds `fraction` of the largest (D 7.1).
  bool stationary(double fraction) const;

  void save(Checkpoint& checkpoint) const;
  /// `time`: that of the checkpoint. Throws Failure if it is of another scene.
  void restore(const Checkpoint& checkpoint, double time);

 private:
  using Watch = effects::ContactDischarge::Watch;
  double longest_step(const std::vector<Watch>& watched, std::span<const double> force) const;
  effects::ElectricalGroups groups_of(const effects::ContactDischarge* discharge) const;
  void charge_bodies(double time);

  const Scene& scene_;
  Model& model_;
  Counters& counters_;
  effects::FloatingConductors& field_;
  effects::ContactDischarge* discharge_;  ///< null: only wires connect
  std::vector<effects::Supply> supplies_;
  effects::ChargeLedger ledger_;
  double booked_until_ = 0;  ///< s, time of the ledger
  effects::ElectricalGroups groups_;
  std::vector<double> current_;  ///< A
  double largest_force_ = 0, largest_speed_ = 0;
};

}  // namespace lichtenberg::mechanics
