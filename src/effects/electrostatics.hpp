#pragma once

#include <vector>

#include "solvers/geometry/vec.hpp"
#include "solvers/laplace/problem.hpp"
#include "src/effects/circuit.hpp"
#include "src/effects/groups.hpp"

namespace lichtenberg::effects {

/// Charges of the nodes (conductors, and electrodes behind a series resistor) as input of a field solve. With
/// resistors, the solve includes the charge that they carry in an implicit time step (charge_step).
struct NodeCharges {
  /// Charge of each node (C); missing elements at the end are 0
  std::vector<double> charge{};
  std::vector<Resistor> resistors{};
  /// Time (s): a resistor carries the charge weight * conductance * (potential difference) in the step. `charge`
  /// includes the charge of Resistor::source.
  double weight = 0;
  double injected_current = 0;  ///< current injected into all conductors together (A)
};

/// Result of a field solve in SI: forces, charges and potentials of the conductors, field energy, charges through
/// resistors. In two dimensions it is for a domain of the scene's depth.
struct Electrostatics {
  std::vector<Vec3> force;        ///< electric force on each conductor (N); z is 0 in two dimensions
  std::vector<double> charge;     ///< charge of each conductor from the field (C), the integral of the surface charge
  std::vector<double> potential;  ///< potential of each conductor (V)
  double energy = 0;              ///< electrostatic energy of the field (J)
  /// Charge (C) through each resistor from a to b in the step: NodeCharges::weight * current at its end
  std::vector<double> carried;
  // Terminals, in the order of terminals_of:
  std::vector<double> terminal_charge;     ///< charge on their surface (C)
  std::vector<double> terminal_potential;  ///< V
};

/// Equipotential groups in the form of a field problem, and the group of each node (conductor, or electrode behind a
/// series resistor).
struct NodeGroups {
  std::vector<laplace::Group> groups;  ///< in ascending order of id
  std::vector<int> group_of_node;      ///< index of each node's group
};

/// Converts equipotential groups to groups of a field problem. A floating group has the sum of the charges of its
/// nodes, divided by `depth` (m; 1 in three dimensions). The other groups have their prescribed potential.
NodeGroups groups_of_nodes(const ElectricalGroups& groups, const NodeCharges& charges, double depth);
/// Writes the result of groups_of_nodes() to `nodes` and reuses the memory there.
void find_groups_of_nodes(const ElectricalGroups& groups, const NodeCharges& charges, double depth, NodeGroups& nodes);

/// Adds resistors to a field problem. Each resistor between two groups becomes a lumped capacitance weight *
/// conductance / depth, appended to `couplings`. With it the field solve includes an implicit time step of the
/// resistor. Each potential source at a resistor becomes a group, appended to `to`. `group_of_node`: group of each
/// node.
void add_couplings(const ElectricalGroups& groups, const NodeCharges& charges, const std::vector<int>& group_of_node,
                   double depth, std::vector<laplace::Group>& to, std::vector<laplace::Coupling>& couplings);

/// Returns the charge (C) that each resistor carries in a step, 0 within one group. `flowed`: charges (C per metre of
/// depth) through the lumped capacitances of add_couplings().
std::vector<double> carried_by_resistors(const ElectricalGroups& groups, const NodeCharges& charges,
                                         const std::vector<double>& flowed, double depth);

/// Subtracts the net charge of the floating groups in equal parts from each of them, because an insulated box allows no
/// net charge. Time steps leave a net charge of the order of the field solver's tolerance.
void neutralize(std::vector<laplace::Group>& groups);

/// Adds a constant to all potentials of a field in an insulated box, which the field equations leave undetermined. With
/// the constant, the total current of resistors to potential sources equals the injected current, because the box
/// allows no net charge (Kirchhoff's current law). The function is for field solves at an instant, in which resistors
/// carry no charge. Without a conducting resistor to a source it has no effect. All terminals must be nodes.
void set_level(Electrostatics& field, const NodeCharges& charges);

}  // namespace lichtenberg::effects
