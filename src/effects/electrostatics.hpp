#pragma once

#include <vector>

#include "solvers/geometry/vec.hpp"
#include "solvers/laplace/problem.hpp"
#include "src/effects/circuit.hpp"
#include "src/effects/groups.hpp"

namespace lichtenberg::effects {

/// The charges that a field is asked for, with what a step of charge through resistors asks of it at its end
/// (charge_step).
struct NodeCharges {
  std::vector<double> charge{};  ///< C, by node of ElectricalGroups; the last may be missing, which have none
  std::vector<Resistor> resistors{};
  /// s: what a resistor carries is weight * conductance * potential difference; what its source carries is in `charge`.
  double weight = 0;
  double fed = 0;     ///< A, into all conductors together
};

/// What the field does to the conductors: a solution with the scene's depth, in SI.
struct Electrostatics {
  std::vector<Vec3> force;        ///< N; in the plane z is 0
  std::vector<double> charge;     ///< C, by the field (D 5.4)
  std::vector<double> potential;  ///< V
  double energy = 0;              ///< J
  std::vector<double> carried;    ///< C, by resistor, from a to b in the step: weight * current at its end
  // Of the terminals, in the order of terminals_of:
  std::vector<double> terminal_charge;     ///< C, on their surface
  std::vector<double> terminal_potential;  ///< V
};

/// The electrical groups as a field problem has them.
struct NodeGroups {
  std::vector<laplace::Group> groups;  ///< in ascending order of id
  std::vector<int> of_node;            ///< index of each node's
};

/// Charges become those per metre of `depth` (m).
NodeGroups groups_of_nodes(const ElectricalGroups& groups, const NodeCharges& charges, double depth);
/// The same into `nodes`, whose memory is used again.
void find_groups_of_nodes(const ElectricalGroups& groups, const NodeCharges& charges, double depth, NodeGroups& nodes);

/// Appends what resistors between groups couple, a group for each supply at the end of one among it. `of_node`: groups
/// of the nodes.
void add_couplings(const ElectricalGroups& groups, const NodeCharges& charges, const std::vector<int>& of_node,
                   double depth, std::vector<laplace::Group>& to, std::vector<laplace::Coupling>& couplings);

/// C, through each resistor: `flowed` (C per metre of depth) are the couplings' that add_couplings has made of them.
std::vector<double> carried_by_resistors(const ElectricalGroups& groups, const NodeCharges& charges,
                                         const std::vector<double>& flowed, double depth);

/// Shares among the floating groups a net charge that an insulated box has no field for: steps leave one of the field
/// solver's tolerance.
void neutralize(std::vector<laplace::Group>& groups);

/// The level of the potentials in an insulated box at an instant, when nothing but resistors leads to a supply and they
/// carry nothing, so that the field leaves it open: their currents are to carry off what is fed, since the box cannot
/// take up any net charge (Kirchhoff's current law). Without any supply it stays as it is. All terminals must be nodes.
void set_level(Electrostatics& field, const NodeCharges& charges);

}  // namespace lichtenberg::effects
