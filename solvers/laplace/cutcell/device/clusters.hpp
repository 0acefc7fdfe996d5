#pragma once

#include <span>
#include <vector>

#include "solvers/laplace/network_factors.hpp"
#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace::device {

/// Groups of a grid that are relaxed together, in clusters of some each: row by row, cluster after cluster. One after
/// the other they would keep what they have in common, which CG's norm does not notice.
struct Clusters {
  std::vector<int> row;          ///< by group, or -1
  std::vector<int> group;        ///< by row
  std::vector<int> first, size;  ///< by row: its cluster's first row, and how many it has
  std::vector<long> start;       ///< by row: of its entries in `inverse`, one for each row of its cluster
  std::vector<double> inverse;   ///< potentials from what flows in, for given potentials of all other groups
};

/// Clusters of at most `most` groups that are joined by the strongest direct links, of those that outweigh the links to
/// cells of either end. `diagonal`: by group, the sum of all its conductances, 0: it has no potential of its own;
/// `links`: between groups, each once.
Clusters clusters_of_direct_links(std::span<const double> diagonal, std::vector<NetworkLink> links, int most);

/// Groups that coarse grids treat like one (../sets.hpp), for `groups` of them, of which the problem has the first.
struct SetLists {
  std::vector<int> of_group;        ///< a set's first group
  std::vector<int> start, group;    ///< by first group: its set's groups
  std::vector<int> is_alone, held;  ///< by group: whether its set is one body that floats; Sets::is_held
};

/// By couplings and the finest grid's direct links. Sets that the coarsest grid, of cells of h m, cannot absorb stay
/// few enough to have its unknowns together: else weaker links are left out.
SetLists list_sets(const LaplaceProblem& problem, std::vector<NetworkLink> links, double h, int groups);

}  // namespace lichtenberg::laplace::device
