#pragma once

#include <span>
#include <string>
#include <vector>

#include "src/effects/contact_discharge.hpp"
#include "src/mechanics/electrical_state.hpp"
#include "src/model/checkpoint.hpp"
#include "src/model/model.hpp"

namespace lichtenberg::mechanics {

/// Currents of series resistors and of electrical contacts with a finite conductance, and their error
/// (ElectricalState::carried).
class ResistorCurrents {
 public:
  /// Makes the currents of a scene. `discharge` is null if only wires connect conductors. All arguments must outlive
  /// this object; `now` may be constructed later.
  ResistorCurrents(const Scene& scene, const Model& model, const effects::ContactDischarge* discharge,
                   const std::vector<effects::Terminal>& terminals,
                   const std::vector<effects::PotentialSource>& supplies, ElectricalState& now)
      : scene_(scene), model_(model), discharge_(discharge), terminals_(terminals), supplies_(supplies), now_(now) {}

  /// Returns true if there are resistors.
  bool any() const { return !now_.carried.resistors.empty(); }
  /// Returns the largest error of a charge that a resistor carries in a trial's step, in tolerances; 0 without
  /// resistors or for a step of length 0. A relative error d of a charge changes a force by about 2 d. A displacement
  /// by d times the distance to the source of the force, at least a radius, has about the same effect. The tolerance is
  /// therefore the fraction position_tolerance / (smallest radius) of the largest charge, or less if field.accuracy
  /// requires it.
  double charge_error(const Trial& trial) const;
  /// Returns true if the conductance of a present contact depends on the contact's state (potential difference or gap).
  bool has_state_dependent_laws() const;
  /// Returns the longest step (s) in which no gap changes by more than half the `gap_scale` of its contact's
  /// conductance law. Only laws that depend on the contact's state count; infinite without them. `force`: present
  /// forces on all bodies (N, [N * dimension]).
  double longest_step(std::span<const double> force) const;
  /// Returns a message about two bodies that touch at different potentials, if at least one of them can move; empty if
  /// there are none. The resistance of their contact has not yet equalized the potentials, and the force between the
  /// two has no limit.
  std::string unequal_contact_message() const;
  /// Throws Failure for two bodies that touch at different prescribed potentials, joined by a contact of finite
  /// conductance: their attraction has no limit.
  void check_fixed_contacts() const;

  /// Rebuilds the list of resistors for the present contacts. If the list or the equipotential groups have changed, the
  /// carried charges are set to 0. The currents then follow from the potentials of the last accepted field (0 before
  /// the first).
  void update(bool groups_changed);
  /// Linearizes the currents of contacts whose conductance depends on their state, about the last accepted field.
  void linearize();
  /// Sets the current (A) of each resistor from the potentials of the last accepted field, by Ohm's law or a contact's
  /// linearized law.
  void estimate_currents();
  /// Adds to the charges of nodes (C; conductors and electrodes behind a resistor) the explicit part of the charge that
  /// resistors carry in a step. This part is known before the field solve.
  void add_charges(const effects::ChargeStep& step, std::vector<double>& charge) const;
  /// Moves the charges that resistors carried in the step of a trial, whose field has been accepted, between their
  /// ends.
  void commit_charges(const Trial& trial);

  /// Returns values by node (an electrical unknown): those of the conductors, then those of the circuits' nodes.
  std::vector<double> by_node(std::vector<double> by_conductor, const std::vector<double>& by_circuit) const;
  /// Returns the potentials (V) of a solved field by node, in the order of by_node().
  std::vector<double> node_potentials(const effects::Electrostatics& field) const;

  /// Saves the currents and carried charges, if there are resistors.
  void save(Checkpoint& checkpoint) const;
  /// Restores currents and carried charges for the present contacts and groups. Throws Failure if the checkpoint's
  /// arrays do not fit the scene.
  void restore(const Checkpoint& checkpoint);

 private:
  std::vector<double> end_potentials(const effects::Electrostatics& field) const;
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
