#pragma once

#include <vector>

#include "solvers/geometry/vec.hpp"
#include "solvers/laplace/problem.hpp"
#include "src/effects/circuit.hpp"
#include "src/effects/groups.hpp"

namespace lichtenberg::effects {

/// Input of a field solve: charges, and the implicit step of charge through resistors at its end (charge_step).
struct NodeCharges {
  /// C, by node of ElectricalGroups; missing elements at the end are 0
  std::vector<double> charge{};
  std::vector<Resistor> resistors{};
  /// s: a resistor transports weight * conductance * potential difference; `charge` includes the charge of its
  /// `source`.
  double weight = 0;
  double injected_current = 0;  ///< A, injected into all conductors together
};

/// Result of a field solve for the scene's depth, in SI.
struct Electrostatics {
  std::vector<Vec3> force;        ///< N; z is 0 in two dimensions
  std::vector<double> charge;     ///< C, from the field (D 5.4)
  std::vector<double> potential;  ///< V
  double energy = 0;              ///< J
  /// C, by resistor, from a to b in the step: weight * current at its end
  std::vector<double> carried;
  // Terminals, in the order of terminals_of:
  std::vector<double> terminal_charge;     ///< C, on their surface
  std::vector<double> terminal_potential;  ///< V
};

/// Electrical groups in the form of a field problem.
struct NodeGroups {
  std::vector<laplace::Group> groups;  ///< in ascending order of id
  std::vector<int> group_of_node;      ///< index of each node's group
};

/// Returns the groups of a field problem; charges are divided by `depth` (m).
NodeGroups groups_of_nodes(const ElectricalGroups& groups, const NodeCharges& charges, double depth);
/// Computes the result of groups_of_nodes in `nodes`, whose memory is reused.
void find_groups_of_nodes(const ElectricalGroups& groups, const NodeCharges& charges, double depth, NodeGroups& nodes);

/// Appends the capacitance of a step (laplace::Coupling) for each resistor between two groups. Appends a group for each
/// potential source at such a resistor. `group_of_node`: groups of the nodes.
void add_couplings(const ElectricalGroups& groups, const NodeCharges& charges, const std::vector<int>& group_of_node,
                   double depth, std::vector<laplace::Group>& to, std::vector<laplace::Coupling>& couplings);

/// Returns the charge (C) through each resistor. `flowed` (C per metre of depth) are the charges through the couplings
/// of add_couplings.
std::vector<double> carried_by_resistors(const ElectricalGroups& groups, const NodeCharges& charges,
                                         const std::vector<double>& flowed, double depth);

/// Distributes among the floating groups a net charge that an insulated box does not allow. Steps leave a net charge of
/// the order of the field solver's tolerance.
void neutralize(std::vector<laplace::Group>& groups);

/// Sets the level of the potentials in an insulated box at an instant, which the field leaves open. This occurs if
/// resistors are the only connection to potential sources, because they carry no charge in an instant. The currents of
/// the resistors must remove the injected charge, because the box allows no net charge (Kirchhoff's current law).
/// Without any source the level is not changed. All terminals must be nodes.
void set_level(Electrostatics& field, const NodeCharges& charges);

}  // namespace lichtenberg::effects
