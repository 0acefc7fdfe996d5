#pragma once

#include <vector>

#include "solvers/laplace/network_factors.hpp"
#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

/// Upper bound of couplings (lumped conductances between groups, per permittivity) on the coarse grids of the
/// preconditioner. Single precision does not distinguish larger couplings. With this bound the elimination in double
/// precision is accurate enough for a preconditioner. A group is a set of bodies with one potential.
constexpr double largest_coarse_coupling = 1e9;

/// Lower bound, in the preconditioner, of couplings (lumped capacitances per permittivity) to given potentials if only
/// such couplings ground the field. The couplings may be arbitrarily weak, but a V-cycle in single precision needs a
/// ground of sufficient strength.
constexpr double least_only_ground = 0.1;
/// Returns the lower bound of couplings (lumped capacitances per permittivity) to given potentials in the
/// preconditioner. It is 0 if a body or an electrode side has a given potential, otherwise `least_only_ground`.
inline double least_in_cycle(const LaplaceProblem& problem) {
  return problem.has_fixed_conductor() ? 0.0 : least_only_ground;
}

/// Agglomerates: sets of groups for coarse grids. A coarse grid keeps the potentials of all groups of a set, or treats
/// the set as part of an effective medium. A group is a set of bodies with one potential. Within a set, couplings
/// (lumped capacitances) or gap conductances are stronger than the links of small disks to the surrounding field.
struct Agglomerates {
  /// By group: the first group of its set, which names the set.
  std::vector<int> first_group;
  /// By a set's first group: whether a group of the set has a given potential. If only couplings ground the field: also
  /// whether a group is coupled to a given potential.
  std::vector<char> is_grounded;
};

/// Minimum conductance (per permittivity) of direct links between groups (bodies with one potential) of one set, where
/// a face between two cells has 1. Four times this value has no equivalent in a medium of small disks. With a smaller
/// value, sets in dense systems extend over the box. Their disks then remain subgrid conductors where a medium would
/// suffice (docs/measurements/negative-results.md). A direct link is the conductance of a gap between two conductors.
constexpr double least_joining = 4;

/// Computes the sets of groups that strong couplings (lumped capacitances) connect, or direct links of more than
/// `least_joining`. Direct links are gap conductances of conductors that nearly touch. `direct_links`: conductances
/// between conductors on the finest grid. A group is a set of bodies with one potential.
Agglomerates find_agglomerates(const LaplaceProblem& problem, const std::vector<NetworkLink>& direct_links);

}  // namespace lichtenberg::laplace
