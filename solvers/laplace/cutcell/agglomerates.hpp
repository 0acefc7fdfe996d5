#pragma once

#include <vector>

#include "solvers/laplace/network_factors.hpp"
#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

/// Upper bound of couplings on coarse grids. Single precision does not distinguish larger ones, and with this bound the
/// elimination in double precision is accurate enough for a preconditioner.
constexpr double largest_coarse_coupling = 1e9;

/// Lower bound, in the cycle, of couplings to given potentials if only these ground the field. They may be arbitrarily
/// weak, but a cycle in single precision needs a ground of sufficient strength.
constexpr double least_only_ground = 0.1;
inline double least_in_cycle(const LaplaceProblem& problem) {
  return problem.has_fixed_conductor() ? 0.0 : least_only_ground;
}

/// Agglomerates: sets of groups that a coarse grid resolves or absorbs together. Their couplings are stronger than the
/// links of small disks to the surrounding field; weaker couplings hardly matter compared with the field.
struct Agglomerates {
  /// First group of each group's set.
  std::vector<int> first_group;
  /// By a set's first group: whether a group of the set has a given potential or is coupled to the field's only ground.
  std::vector<char> is_grounded;
};

/// Minimum conductance of direct links between groups of one set. A gap that conducts four times as much as a face
/// between two cells has no equivalent in a medium of small disks. With a smaller value, sets in dense systems extend
/// over the box, and their disks remain subgrid conductors where a medium would suffice
/// (docs/measurements/negative-results.md).
constexpr double least_joining = 4;

/// Returns the sets connected by strong couplings and by those of the finest grid's direct links that exceed
/// `least_joining`, which are links of conductors that nearly touch.
Agglomerates find_agglomerates(const LaplaceProblem& problem, const std::vector<NetworkLink>& direct_links);

}  // namespace lichtenberg::laplace
