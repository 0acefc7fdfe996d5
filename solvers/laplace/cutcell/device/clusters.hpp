#pragma once

#include <span>
#include <vector>

#include "solvers/laplace/network_factors.hpp"
#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace::device {

/// Clusters of groups of a grid that are relaxed together, row by row, cluster after cluster. Sequential relaxation
/// would leave the error that a cluster's groups have in common, which CG's norm does not notice.
struct Clusters {
  std::vector<int> row;          ///< by group, or -1
  std::vector<int> group;        ///< by row
  std::vector<int> first, size;  ///< by row: its cluster's first row and number of rows
  std::vector<long> start;       ///< by row: start of its entries in `inverse`, one per row of its cluster
  std::vector<double> inverse;   ///< from inflow to potentials, for given potentials of all other groups
};

/// Network of a grid's groups.
struct GroupNetwork {
  std::vector<double> diagonal;         ///< by group: the sum of its links' conductances; 0: no potential of its own
  std::vector<NetworkLink> links = {};  ///< direct ones between groups, each once, of whatever groups
  std::vector<NetworkLink> couplings = {};  ///< between groups that have potentials; not in the diagonals
  std::vector<double> hold = {};            ///< by group: couplings to given potentials; or empty
};

/// Network of the groups that have links to others, usually a small fraction of all.
struct LinkedGroups {
  GroupNetwork network;
  std::vector<int> group;  ///< by the network's numbers, ascending

  /// Builds the network of the groups that have links. `diagonal`: by group. `index`: scratch memory that is reused;
  /// empty at first, then -1 by group.
  static LinkedGroups of(std::span<const double> diagonal, std::vector<NetworkLink> links, std::vector<int>& index);
};

/// Adds the problem's couplings (set_couplings). `largest`: upper bound of conductances; `least`: lower bound of those
/// to given potentials.
void couple(const LaplaceProblem& problem, double largest, double least, GroupNetwork& network);

/// Computes clusters of at most `most` groups, joined by the strongest direct links that outweigh the links to cells of
/// either end; couplings join without bound. `all`: direct links of any strength join without bound, so that clusters
/// do not interact.
Clusters clusters_of(GroupNetwork network, int most, bool all = false);

/// Sets of groups that coarse grids treat as one (../agglomerates.hpp), for `groups` groups, of which the problem has
/// the first.
struct AgglomerateLists {
  std::vector<int> first_group;     ///< a set's first group
  std::vector<int> start, group;    ///< by first group: its set's groups
  std::vector<int> is_alone, held;  ///< by group: whether its set is one body that floats; Agglomerates::is_grounded
};

/// Makes sets by couplings and the finest grid's direct links. Weaker links are left out until few groups of sets
/// remain unknowns of the coarsest grid, which has cells of h m.
AgglomerateLists list_agglomerates(const LaplaceProblem& problem, std::vector<NetworkLink> links, double h, int groups);

}  // namespace lichtenberg::laplace::device
