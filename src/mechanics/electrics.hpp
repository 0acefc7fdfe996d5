#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "src/effects/conductor_frame.hpp"
#include "src/effects/contact_discharge.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/mechanics/charging.hpp"
#include "src/mechanics/counters.hpp"
#include "src/mechanics/cvode.hpp"
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

/// What making and losing contacts has led to.
struct Regrouping {
  bool merged = false;          ///< charges have moved, and the field is another
  std::vector<Merger> mergers;  ///< if so
};

/// What may happen to contacts on a way that is foreseen.
struct Lookahead {
  /// Where a body was, and how far (m) it was to move at most.
  struct Foreseen {
    int body = 0;
    std::array<double, 3> start{};  ///< m
    double reach = 0;               ///< m
  };
  std::vector<effects::ContactDischarge::Watch> watched;  ///< contacts that may change
  std::vector<Foreseen> foreseen;                         ///< bodies that may move farther
  double least_reach = 0;                                 ///< m, of any body
};

/// The electric half of a conductor scene: who is connected with whom, who holds which charge, what the field does. All
/// that goes on in time is its Charging. A solve returns a Trial and leaves that alone; accept() makes the trial true.
class Electrics {
 public:
  /// `field` and `discharge` are the model's; `discharge` is null if only wires connect. All must outlive this.
  Electrics(const Scene& scene, Model& model, effects::FloatingConductors& field,
            const effects::ContactDischarge* discharge, Counters& counters);
  Electrics(const Electrics&) = delete;  // the field effect looks at its Charging
  Electrics& operator=(const Electrics&) = delete;

  const Charging& now() const { return now_; }
  /// Everything electric is as it was in `before`.
  void go_back(const Charging& before) { now_ = before; }
  /// What is to act on the bodies from now on.
  void hold(effects::HeldField held) { now_.held = std::move(held); }
  /// The same: the field as it was accepted last, at `time` (s).
  void hold(double time, Rates rates);

  /// Contacts and groups of the first instant. Throws InputError for a short circuit.
  void connect();
  /// Solves the field where the bodies are, with the charges that they will have at `time`.
  Trial solve(double time, FieldGrid grid = FieldGrid::whole);
  /// The error of a trial's charges, in tolerances; 0 if nothing carries charge at a finite rate. A conductor whose
  /// charge is wrong by a fraction d feels a force wrong by 2 d, as if it were displaced by some d of the distance to
  /// what acts on it, which is a radius or more: a tolerance is position_tolerance / radius of the largest charge,
  /// or less if the accuracy asked of the field asks for it (charge_tolerance).
  double charge_error(const Trial& trial) const;
  /// Books the charges fed until the trial's instant, and shares them as its field does. The bodies must be where they
  /// were when it was solved, and nothing else must have been booked since. Throws Failure with the sentence of
  /// pressed_apart_in_potential.
  void accept(Trial trial) { accept(std::move(trial), false); }
  /// Whether anything carries charge at a finite rate: what it carried is known after a solve only.
  bool has_resistors() const { return !now_.carried.resistors.empty(); }
  /// Books and shares as accept does, at an instant without a solve, with charges `by_field` (C) known otherwise. Not
  /// with resistors.
  void share(double time, std::span<const double> by_field);
  /// Makes and loses contacts where the bodies are now. If groups part, their members keep the charges that they have:
  /// these must be accepted or shared at this instant. If groups merge, charges move: solves, accepts and returns true.
  /// Groups that only part keep charges, potentials and so the field as it was accepted, and what is lost after a
  /// merger was due parts behind it. `due_since`: s, since when a contact may have been due. Throws Failure for a short
  /// circuit.
  Regrouping reconnect(double time, double due_since, FieldGrid grid = FieldGrid::whole);
  Regrouping reconnect(double time) { return reconnect(time, time); }

  /// The contacts that may change while body i moves by less than reach[i] (m). `thrown`: the bodies that may move
  /// farther, since what elastic contacts do to them is not known beforehand; empty: all.
  Lookahead look_ahead(std::span<const double> reach, const std::optional<std::vector<int>>& thrown = {}) const;
  /// The same as events, and one event more, the last, for the first body that moves farther. If mergers wait, contacts
  /// that are made are events only where they can do so no longer. `ahead` must outlive them. No events without
  /// contact_discharge.
  Events events(const Lookahead& ahead, bool mergers_wait = false) const;
  /// Ways become a little longer: a body that moves exactly as far as it can is no event.
  void widen(std::span<double> ways) const;

  /// Says which conductor touches another, or an electrode, at another potential, since a contact's resistance has not
  /// made them one; the force between such has no limit. Empty: none does.
  std::string pressed_apart_in_potential() const;

  effects::FloatingConductors& field() { return field_; }
  /// The gap (m) below which conductors are one; infinite without contacts.
  double contact_gap() const;
  /// Whether a contact that is looked ahead for is to be made, or lost, where the bodies are.
  struct Due {
    bool made = false, lost = false;
  };
  Due due(const Lookahead& ahead) const;
  /// Whether conductors that come close are one electrically.
  bool has_contacts() const { return discharge_ != nullptr; }
  /// What every supply (supplies_of) shows at the instant of the last accepted solve.
  std::vector<TerminalReading> terminals() const;
  /// Null in a scene without a circuit.
  EnergyBook* energy() { return now_.energy ? &*now_.energy : nullptr; }
  /// Every group is held by an electrode, and no force or speed exceeds `fraction` of the largest (D 7.1).
  bool stationary(double fraction) const;

  void save(Checkpoint& checkpoint) const;
  /// `time`: that of the checkpoint. Throws Failure if it is of another scene.
  void restore(const Checkpoint& checkpoint, double time);

 private:
  using Watch = effects::ContactDischarge::Watch;
  effects::ContactDischarge::Changes look_at_contacts();
  bool keep(std::span<const effects::Contact> lost);
  void drop(std::span<const effects::Contact> lost);
  bool regroup(double time, FieldGrid grid);
  std::vector<Merger> mergers(std::span<const effects::Contact> made, double time, double due_since) const;
  std::vector<effects::Contact> lost_after(std::span<const Merger> mergers, std::span<const effects::Contact> lost,
                                           double time) const;
  std::pair<int, int> groups_of(effects::Contact contact) const;
  Events foreseen_events(std::span<const Watch> watched, bool mergers_wait) const;
  double longest_step(const std::vector<Watch>& watched, std::span<const double> force) const;
  double farthest_beyond(std::span<const Lookahead::Foreseen> foreseen, double farthest) const;
  std::vector<double> currents(double time) const;
  void show_charges();
  void note_largest();
  void accept(Trial trial, bool merged);
  void carry_resistors(const Trial& trial);
  void book_energy(const Trial& trial, bool merged);
  void guess_currents();
  void update_resistors(bool groups_changed);
  std::vector<double> by_node(std::vector<double> by_conductor, const std::vector<double>& by_terminal) const;
  std::vector<double> node_potentials(const effects::Electrostatics& field) const;
  double difference_over(const effects::Resistor& resistor, std::span<const double> node_potential) const;
  double resistor_current(const effects::Resistor& resistor, std::span<const double> node_potential) const;
  void restore_linearization(const Checkpoint& checkpoint);
  bool has_laws_of_state() const;
  effects::ContactState state_of(const effects::Resistor& resistor, std::span<const double> node_potential) const;
  void linearize();
  double linearization_error(const Trial& trial) const;
  double largest_potential(std::span<const double> node_potential) const;
  double work_since_booking(double time) const;
  effects::Contact contact_of(const effects::Resistor& resistor) const;
  bool is_held_at_both_ends(const effects::Resistor& resistor) const;
  std::string sentence_about(const effects::Resistor& resistor, double difference) const;
  void check_held_contacts() const;
  bool touch(effects::Contact contact) const;

  const Scene& scene_;
  Model& model_;
  Counters& counters_;
  effects::FloatingConductors& field_;
  const effects::ContactDischarge* discharge_;  ///< null: only wires connect
  std::vector<effects::Terminal> terminals_;
  std::vector<effects::Supply> supplies_;
  double relaxation_time_;  ///< s, of leakage
  Charging now_;
};

}  // namespace lichtenberg::mechanics
