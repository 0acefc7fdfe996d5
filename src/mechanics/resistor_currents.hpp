#pragma once

#include <span>
#include <string>
#include <vector>

#include "src/effects/contact_discharge.hpp"
#include "src/mechanics/electrical_state.hpp"
#include "src/model/checkpoint.hpp"
#include "src/model/model.hpp"

namespace lichtenberg::mechanics {

/// Currents of series resistors and of contacts with a finite conductance (ElectricalState::carried).
class ResistorCurrents {
 public:
  /// `discharge` is null if only wires connect conductors. All arguments must outlive this object; `now` may be
  /// constructed later.
  ResistorCurrents(const Scene& scene, const Model& model, const effects::ContactDischarge* discharge,
                   const std::vector<effects::Terminal>& terminals,
                   const std::vector<effects::PotentialSource>& supplies, ElectricalState& now)
      : scene_(scene), model_(model), discharge_(discharge), terminals_(terminals), supplies_(supplies), now_(now) {}

  /// Returns true if there are resistors. The charge that they carry is known only after a solve.
  bool any() const { return !now_.carried.resistors.empty(); }
  /// Returns the error of a trial's charges, in tolerances; 0 without resistors. A relative error d of a charge changes
  /// the force by 2 d, like a displacement by about d times the distance to the source of the force, which is at least
  /// a radius. A tolerance is therefore position_tolerance / radius of the largest charge, or less if the field's
  /// accuracy requires it.
  double charge_error(const Trial& trial) const;
  /// Returns true if the law of a present contact depends on its state.
  bool has_state_dependent_laws() const;
  /// Returns the longest step (s) in which no gap changes by more than half the `gap_scale` of its contact's law;
  /// infinite without such laws. Arguments: the present velocities and forces (N, all components of all bodies).
  double longest_step(std::span<const double> force) const;
  /// Returns a message about a conductor that touches another, or an electrode, at another potential; empty if there is
  /// none. The contact's resistance has not yet equalized the potentials, and the force between the two has no limit.
  std::string unequal_contact_message() const;
  /// Throws Failure for two bodies that touch at different prescribed potentials: their attraction would never end.
  void check_fixed_contacts() const;

  /// Updates the resistors to the present contacts.
  void update(bool groups_changed);
  /// Linearizes contacts whose law depends on their state, about the state of the last accepted field.
  void linearize();
  /// Sets the currents from the potentials of the last accepted field.
  void estimate_currents();
  /// Adds to the charges of nodes (C) the part of a step's carried charges that is known before its solve.
  void add_charges(const effects::ChargeStep& step, std::vector<double>& charge) const;
  /// Records the charges carried in the step of a trial whose field is accepted.
  void commit_charges(const Trial& trial);

  /// Returns values by node: those of the conductors, then those of terminals behind a resistor.
  std::vector<double> by_node(std::vector<double> by_conductor, const std::vector<double>& by_terminal) const;
  std::vector<double> node_potentials(const effects::Electrostatics& field) const;  ///< V

  void save(Checkpoint& checkpoint) const;
  /// Restores currents for the present contacts and groups. Throws Failure for a checkpoint of another scene.
  void restore(const Checkpoint& checkpoint);

 private:
  double difference_over(const effects::Resistor& resistor, std::span<const double> node_potential) const;
  double current_through(const effects::Resistor& resistor, std::span<const double> node_potential) const;
  effects::ContactState state_of(const effects::Resistor& resistor, std::span<const double> node_potential) const;
  double linearization_error(const Trial& trial) const;
  double largest_potential(std::span<const double> node_potential) const;
  effects::Contact contact_of(const effects::Resistor& resistor) const;
  bool has_fixed_potentials(const effects::Resistor& resistor) const;
  std::string contact_message(const effects::Resistor& resistor, double difference) const;
  bool touch(effects::Contact contact) const;

  const Scene& scene_;
  const Model& model_;
  const effects::ContactDischarge* discharge_;
  const std::vector<effects::Terminal>& terminals_;
  const std::vector<effects::PotentialSource>& supplies_;
  ElectricalState& now_;
};

}  // namespace lichtenberg::mechanics
