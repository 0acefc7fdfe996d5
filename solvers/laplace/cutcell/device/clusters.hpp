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

/// What links a grid's groups.
struct GroupNetwork {
  std::vector<double> diagonal;         ///< by group: the sum of its links' conductances; 0: no potential of its own
  std::vector<NetworkLink> links = {};  ///< direct ones between groups, each once, of whatever groups
  std::vector<NetworkLink> couplings = {};  ///< between groups that have potentials; not in the diagonals
  std::vector<double> hold = {};            ///< by group: couplings to given potentials; or empty
};

/// The network of those groups alone that have links with others: in a crowd of thousands a few.
struct LinkedGroups {
  GroupNetwork network;
  std::vector<int> group;  ///< by the network's numbers, ascending

  /// `diagonal`: by group. `place`: memory for this, which is kept as it is: empty at first, then -1 by group.
  static LinkedGroups of(std::span<const double> diagonal, std::vector<NetworkLink> links, std::vector<int>& place);
};

/// Adds the problem's couplings (set_couplings). `largest`: what stronger ones are taken for; `least`: what weaker
/// ones to given potentials are.
void couple(const LaplaceProblem& problem, double largest, double least, GroupNetwork& network);

/// Clusters of at most `most` groups that are joined by the strongest direct links, of those that outweigh the links to
/// cells of either end, and of however many that are joined by couplings. `all`: by direct links of any strength, of
/// however many, so that what one cluster brings another is nothing.
Clusters clusters_of(GroupNetwork network, int most, bool all = false);

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
