#pragma once

#include <span>
#include <string>
#include <vector>

#include "src/effects/contact_discharge.hpp"
#include "src/mechanics/charging.hpp"
#include "src/model/checkpoint.hpp"
#include "src/model/model.hpp"

namespace lichtenberg::mechanics {

/// Charge that series resistors and contacts carry at a finite rate (Charging::carried).
class ResistorCurrents {
 public:
  /// `discharge` is null if only wires connect. All must outlive this; `now` may be made later.
  ResistorCurrents(const Scene& scene, const Model& model, const effects::ContactDischarge* discharge,
                   const std::vector<effects::Terminal>& terminals, const std::vector<effects::Supply>& supplies,
                   Charging& now)
      : scene_(scene), model_(model), discharge_(discharge), terminals_(terminals), supplies_(supplies), now_(now) {}

  /// Whether there are any: what they have carried is known after a solve only.
  bool any() const { return !now_.carried.resistors.empty(); }
  /// The error of a trial's charges, in tolerances; 0 if nothing carries charge at a finite rate. A conductor whose
  /// charge is wrong by a fraction d feels a force wrong by 2 d, as if it were displaced by some d of the distance to
  /// what acts on it, which is a radius or more: a tolerance is position_tolerance / radius of the largest charge,
  /// or less if the accuracy asked of the field asks for it (charge_tolerance).
  double charge_error(const Trial& trial) const;
  /// Whether the law of a present contact depends on its state.
  bool has_laws_of_state() const;
  /// Returns the longest step (s) in which no gap changes by more than half the `gap_scale` of its contact's law, for
  /// the present velocities and forces (N, all components of all bodies); infinite without such laws.
  double longest_step(std::span<const double> force) const;
  /// Says which conductor touches another, or an electrode, at another potential, since a contact's resistance has not
  /// made them one; the force between such has no limit. Empty: none does.
  std::string pressed_apart_in_potential() const;
  /// Throws Failure for two that touch and are held at different potentials: they would attract each other for ever.
  void check_held_contacts() const;

  /// The resistors of the contacts as they are.
  void update(bool groups_changed);
  /// Linearizes contacts whose law depends on their state about that of the last accepted field.
  void linearize();
  /// Takes the currents from the potentials of the last accepted field.
  void guess();
  /// Adds to the charges of nodes (C) what is known beforehand of what a step carries.
  void add_charges(const effects::ChargeStep& step, std::vector<double>& charge) const;
  /// Books what was carried in the step of a trial whose field is accepted.
  void carry(const Trial& trial);

  /// Values of the conductors, then those of the terminals behind a resistor.
  std::vector<double> by_node(std::vector<double> by_conductor, const std::vector<double>& by_terminal) const;
  std::vector<double> node_potentials(const effects::Electrostatics& field) const;  ///< V

  void save(Checkpoint& checkpoint) const;
  /// With the contacts and groups as they are. Throws Failure if the checkpoint is of another scene.
  void restore(const Checkpoint& checkpoint);

 private:
  double difference_over(const effects::Resistor& resistor, std::span<const double> node_potential) const;
  double current_through(const effects::Resistor& resistor, std::span<const double> node_potential) const;
  effects::ContactState state_of(const effects::Resistor& resistor, std::span<const double> node_potential) const;
  double linearization_error(const Trial& trial) const;
  double largest_potential(std::span<const double> node_potential) const;
  effects::Contact contact_of(const effects::Resistor& resistor) const;
  bool is_held_at_both_ends(const effects::Resistor& resistor) const;
  std::string sentence_about(const effects::Resistor& resistor, double difference) const;
  bool touch(effects::Contact contact) const;

  const Scene& scene_;
  const Model& model_;
  const effects::ContactDischarge* discharge_;
  const std::vector<effects::Terminal>& terminals_;
  const std::vector<effects::Supply>& supplies_;
  Charging& now_;
};

}  // namespace lichtenberg::mechanics
