#pragma once

#include <optional>
#include <vector>

#include "src/effects/charge_ledger.hpp"
#include "src/effects/conductor_frame.hpp"
#include "src/effects/contact_discharge.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/mechanics/counters.hpp"
#include "src/mechanics/cvode.hpp"
#include "src/mechanics/energy_book.hpp"
#include "src/model/checkpoint.hpp"
#include "src/model/model.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::mechanics {

/// The electric half of a conductor scene: who is connected with whom, who holds which charge, what the field does.
/// Steppers call it in this order: solve (as often as they try), settle (once a step is accepted), reconnect.
class Electrics {
 public:
  /// `field` and `discharge` are the model's; `discharge` is null if only wires connect. All must outlive this.
  Electrics(const Scene& scene, Model& model, effects::FloatingConductors& field, effects::ContactDischarge* discharge,
            Counters& counters);

  /// Contacts and groups of the first instant. Throws InputError for a short circuit.
  void connect();
  /// Gives the bodies the charges of `time` and solves the field. Changes nothing else: a step can still be taken back.
  const effects::Electrostatics& solve(double time);
  /// The error of the charges that the last solve was made with, in tolerances; 0 if nothing carries charge at a
  /// finite rate. A conductor whose charge is wrong by a fraction d feels a force wrong by 2 d, as if it were displaced
  /// by some d of the distance to what acts on it, which is a radius or more: a tolerance is position_tolerance /
  /// radius of the largest charge.
  double charge_error(double time) const;
  /// Whether `solve` from now on only predicts, on a coarser grid; the field effect must have a predictor.
  void set_predicting(bool on) { predicting_ = on; }
  /// Books the charges fed until `time`, the instant of the last solve, and shares them as that field does.
  void settle(double time);
  /// Whether anything carries charge at a finite rate: what it carried is known after a solve only.
  bool has_resistors() const { return !resistors_.empty(); }
  /// Books and shares as settle does, at an instant without a solve, with charges `by_field` (C) known otherwise. Not
  /// with resistors.
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

  /// Says which conductor overlaps another, or an electrode, at another potential, since a contact's resistance has not
  /// made them one; the force between such has no limit. Empty: none does.
  std::string pressed_apart_in_potential() const;

  const effects::Electrostatics& last() const { return field_.last(); }
  effects::FloatingConductors& field() { return field_; }
  /// The gap (m) below which conductors are one; infinite without contacts.
  double contact_gap() const;
  const effects::ElectricalGroups& groups() const { return groups_; }
  const effects::ChargeLedger& ledger() const { return ledger_; }
  /// Whether conductors that come close are one electrically, and which are, in ascending order.
  bool has_contacts() const { return discharge_ != nullptr; }
  std::vector<effects::Contact> contacts() const {
    return discharge_ ? discharge_->contacts() : std::vector<effects::Contact>{};
  }
  /// What every supply (supplies_of) shows at the instant of the last solve, with the charges of the last settle or
  /// share.
  std::vector<TerminalReading> terminals() const;
  /// Null in a scene without a circuit.
  EnergyBook* energy() { return energy_ ? &*energy_ : nullptr; }
  /// Every group is held by an electrode, and no force or speed exceeds `fraction` of the largest (D 7.1).
  bool stationary(double fraction) const;

  void save(Checkpoint& checkpoint) const;
  /// `time`: that of the checkpoint. Throws Failure if it is of another scene.
  void restore(const Checkpoint& checkpoint, double time);

 private:
  using Watch = effects::ContactDischarge::Watch;
  double longest_step(const std::vector<Watch>& watched, std::span<const double> force) const;
  effects::ElectricalGroups groups_of(const effects::ContactDischarge* discharge) const;
  void show_charges();
  void settle(double time, bool merged);
  void carry_resistors(const effects::ChargeStep& step);
  void book_energy(double time, bool merged, std::span<const double> carried);
  void guess_currents();
  void update_resistors(bool groups_changed);
  std::vector<double> by_node(std::vector<double> by_conductor, const std::vector<double>& by_terminal) const;
  std::vector<double> node_potentials() const;
  double resistor_current(const effects::Resistor& resistor, std::span<const double> node_potential) const;
  double work_since_booking(double time) const;
  effects::Contact contact_of(const effects::Resistor& resistor) const;
  bool is_held_at_both_ends(const effects::Resistor& resistor) const;
  std::string sentence_about(const effects::Resistor& resistor, double difference) const;
  void check_held_contacts() const;

  const Scene& scene_;
  Model& model_;
  Counters& counters_;
  effects::FloatingConductors& field_;
  effects::ContactDischarge* discharge_;  ///< null: only wires connect
  std::vector<effects::Terminal> terminals_;
  std::vector<effects::Supply> supplies_;
  effects::ChargeLedger ledger_;
  double booked_until_ = 0;  ///< s, time of the ledger
  effects::ElectricalGroups groups_;
  std::vector<double> current_;  ///< A, that the effects feed
  // What carries charge at a finite rate, and its last step:
  double relaxation_time_;  ///< s, of leakage
  std::vector<effects::Resistor> resistors_;
  std::vector<double> resistor_current_, remaining_, plain_;  ///< A, C, C, by resistor (charge_step)
  double current_noise_ = 1;  ///< 1: resistor_current_ is from potentials, with the solver's error; 0: from a step
  double last_step_ = 0;      ///< s; 0: none whose currents lead smoothly to the next
  effects::ImplicitCharges implicit_;  ///< of the last solve
  std::optional<EnergyBook> energy_;
  std::vector<double> booked_at_;  ///< positions when energy was last booked
  std::vector<Vec2> booked_force_;
  bool predicting_ = false;
  double largest_force_ = 0, largest_speed_ = 0;  ///< N, m/s, of a body at any instant that was settled
};

}  // namespace lichtenberg::mechanics
