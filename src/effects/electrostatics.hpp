#pragma once

#include <array>
#include <vector>

#include "solvers/geometry/vec.hpp"
#include "solvers/laplace/problem.hpp"
#include "src/effects/circuit.hpp"
#include "src/effects/groups.hpp"

namespace lichtenberg::effects {

/// Charges of the nodes (conductors and circuit_nodes()) as input of a field solve. With
/// resistors, the solve includes the charge that they carry in an implicit time step (charge_step).
struct NodeCharges {
  /// Charge of each node (C); missing elements at the end are 0
  std::vector<double> charge{};
  std::vector<Resistor> resistors{};
  /// Time (s): a resistor carries the charge weight * conductance * (potential difference) in the step. `charge`
  /// includes the charge of Resistor::source.
  double weight = 0;
  double injected_current = 0;  ///< current injected into all nodes together (A)
  /// Potentials (V) of the sources at the instant, potentials_at(); empty: those of the scene, which are constant
  std::vector<double> supply_potential{};
  /// Capacitors between a node and 0 V (F, by node from the first circuit node on); missing elements at the end are 0
  std::vector<double> capacitance{};

  /// Returns the potential (V) of a source. `constant`: its potential if it does not vary.
  double potential_of(int supply, double constant) const {
    return supply_potential.empty() ? constant : supply_potential[supply];
  }
};

/// Result of a field solve in SI: forces, charges and potentials of the conductors, field energy, charges through
/// resistors. In two dimensions it is for a domain of the scene's depth.
struct Electrostatics {
  std::vector<Vec3> force;        ///< electric force on each conductor (N); z is 0 in two dimensions
  std::vector<double> charge;     ///< charge of each conductor from the field (C), the integral of the surface charge
  std::vector<double> potential;  ///< potential of each conductor (V)
  double energy = 0;              ///< electrostatic energy of the field and of capacitors (J)
  /// Charge (C) through each resistor from a to b in the step: NodeCharges::weight * current at its end
  std::vector<double> carried;
  // Terminals, in the order of terminals_of:
  std::vector<double> terminal_charge;     ///< charge on their surface (C)
  std::vector<double> terminal_potential;  ///< V
  std::vector<double> circuit_potential;   ///< V, by circuit node
  std::vector<double> circuit_charge;      ///< C, by circuit node: its terminals and its capacitor
  std::vector<double> supply_potential;    ///< V, NodeCharges::supply_potential
};

/// Equipotential groups in the form of a field problem, and the group of each node (conductor or circuit node).
struct NodeGroups {
  std::vector<laplace::Group> groups;  ///< in ascending order of id
  std::vector<int> group_of_node;      ///< index of each node's group
};

/// Converts equipotential groups to groups of a field problem. A floating group has the sum of the charges of its
/// nodes, divided by `depth` (m; 1 in three dimensions). The other groups have their prescribed potential.
NodeGroups groups_of_nodes(const ElectricalGroups& groups, const NodeCharges& charges, double depth);
/// Writes the result of groups_of_nodes() to `nodes` and reuses the memory there.
void find_groups_of_nodes(const ElectricalGroups& groups, const NodeCharges& charges, double depth, NodeGroups& nodes);

/// Sides of the domain that belong to one group of a field problem, whose charge is given and whose potential is not.
struct FloatingSides {
  int group = 0;
  std::vector<int> sides;
};

/// Returns the groups of a field problem that have sides of the domain, from the scene's circuits. `group_of_node`:
/// group of each node.
std::vector<FloatingSides> floating_sides(const Scene& scene, const std::vector<int>& group_of_node);

/// Returns the potential (V) of each side of the domain: of the scene or, if it varies, at the instant; 0 for a side in
/// a circuit.
std::array<double, 6> side_potentials(const Scene& scene, const NodeCharges& charges);

/// Returns the potentials (V) of the circuits' nodes, from those of the groups of a field problem.
std::vector<double> circuit_potentials(const std::vector<double>& group_potential,
                                       const std::vector<int>& group_of_node, std::size_t conductors);

/// Adds resistors to a field problem. Each resistor between two groups becomes a lumped capacitance weight *
/// conductance / depth, appended to `couplings`. With it the field solve includes an implicit time step of the
/// resistor. Each potential source at a resistor becomes a group, appended to `to`. Capacitors become couplings to a
/// group at 0 V, after those of resistors. `group_of_node`: group of each node.
void add_couplings(const ElectricalGroups& groups, const NodeCharges& charges, const std::vector<int>& group_of_node,
                   double depth, std::vector<laplace::Group>& to, std::vector<laplace::Coupling>& couplings);

/// Returns the charge (C) that each resistor carries in a step, 0 within one group. `flowed`: charges (C per metre of
/// depth) through the lumped capacitances of add_couplings().
std::vector<double> carried_by_resistors(const ElectricalGroups& groups, const NodeCharges& charges,
                                         const std::vector<double>& flowed, double depth);

/// Sets the circuit nodes' potentials and charges in `result` from its terminals, adds the energy of capacitors, and
/// stores the potentials of sources. `potential`: V, of each circuit node.
void add_circuits(const std::vector<Terminal>& terminals, const NodeCharges& charges, std::vector<double> potential,
                  Electrostatics& result);

/// Subtracts the net charge of the floating groups in equal parts from each of them, because an insulated box allows no
/// net charge. Time steps leave a net charge of the order of the field solver's tolerance.
void neutralize(std::vector<laplace::Group>& groups);

/// Adds a constant to all potentials of a field in an insulated box, which the field equations leave undetermined. With
/// the constant, the total current of resistors to potential sources equals the injected current, because the box
/// allows no net charge (Kirchhoff's current law). The function is for field solves at an instant, in which resistors
/// carry no charge. Without a conducting resistor to a source it has no effect. All terminals must be nodes.
void set_level(Electrostatics& field, const NodeCharges& charges);

}  // namespace lichtenberg::effects
