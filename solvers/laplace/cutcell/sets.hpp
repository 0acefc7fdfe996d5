#pragma once

#include <vector>

#include "solvers/laplace/network_factors.hpp"
#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

/// What coarse grids take stronger couplings for: more is the same in single precision, and what elimination in double
/// precision keeps of the rest is enough for a preconditioner.
constexpr double largest_coarse_coupling = 1e9;

/// What the cycle takes weaker couplings to given potentials for: those that are all that grounds the field may be weak
/// by any factor, and it needs a ground to stand on.
constexpr double least_only_ground = 0.1;
inline double least_in_cycle(const LaplaceProblem& problem) {
  return problem.has_fixed_conductor() ? 0.0 : least_only_ground;
}

/// Groups that a coarse grid treats like one: those that are coupled more strongly than small disks are to the field
/// around them. Weaker couplings matter little beside the field. `is_held` says of a set, by its first group, whether
/// anything in it has a given potential, or is all that the field has for ground.
struct Sets {
  std::vector<int> of_group;  ///< a set's first group
  std::vector<char> is_held;
};

/// Direct links, conductances, that join groups: what lets four times as much through as a face between two cells is
/// not what a medium of small disks can be taken for. Sets that are joined by less grow over the box in a crowd, and
/// its disks stay thin conductors where a medium would do. Table in README.md.
constexpr double least_joining = 4;

/// By couplings, and by those of the finest grid's direct links that conduct more than `least_joining`: of conductors
/// that all but touch.
Sets strongly_coupled(const LaplaceProblem& problem, const std::vector<NetworkLink>& direct_links);

}  // namespace lichtenberg::laplace
