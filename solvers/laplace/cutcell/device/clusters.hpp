#pragma once

#include <span>
#include <vector>

#include "solvers/laplace/network_factors.hpp"
#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace::device {

/// Clusters of a grid: sets of groups whose potentials are relaxed together by an inverse matrix. The groups of a
/// cluster (each a set of bodies with one potential) mostly have large conductances between them. Rows are numbered
/// cluster after cluster. Sequential relaxation would leave the common error of a cluster's groups, which CG's norm
/// does not notice.
struct Clusters {
  /// By group: its row, or -1 outside all clusters.
  std::vector<int> row;
  /// By row: its group.
  std::vector<int> group;
  /// By row: first row and number of rows of its cluster.
  std::vector<int> first, size;
  /// By row: start of its entries in `inverse`, one per row of its cluster.
  std::vector<long> start;
  /// Inverse matrices, from the flux into each group to the potentials, for given potentials of all other groups.
  std::vector<double> inverse;
};

/// Network of conductances between the groups (bodies with one potential) of a grid.
struct GroupNetwork {
  /// By group: the sum of its links' conductances; 0 for a group without an unknown potential.
  std::vector<double> diagonal;
  /// Direct links (gap conductances) between groups, each once. They may lead to groups without an unknown potential.
  std::vector<NetworkLink> links = {};
  /// Couplings (lumped capacitances per permittivity) between groups with unknown potentials, not in the diagonals.
  std::vector<NetworkLink> couplings = {};
  /// By group: sum of its couplings to given potentials; empty without couplings.
  std::vector<double> hold = {};
};

/// Network of those groups (bodies with one potential) that have direct links (gap conductances) to others, usually a
/// small fraction of all groups.
struct LinkedGroups {
  GroupNetwork network;
  /// Group of each node of the network, ascending.
  std::vector<int> group;

  /// Builds the network of the groups (bodies with one potential) that have conductances to each other. `diagonal`: by
  /// group. `index`: scratch memory for repeated calls, empty at first and -1 for each group afterwards.
  static LinkedGroups of(std::span<const double> diagonal, std::vector<NetworkLink> links, std::vector<int>& index);
};

/// Adds the problem's couplings (lumped capacitances, divided by the permittivity) between groups to the network. A
/// group is a set of bodies with one potential. Leaves out couplings of a floating group that has no other conductances
/// (network.diagonal is 0). `largest`: upper bound of the conductance of a coupling. `least`: lower bound of the
/// conductance of a coupling to a group of given potential.
void couple(const LaplaceProblem& problem, double largest, double least, GroupNetwork& network);

/// Computes clusters (groups solved together) and their inverse matrices. Couplings (lumped capacitances) join groups
/// to clusters of any size. Gap conductances that are not small against the conductances to cells join groups to
/// clusters of at most `most` groups, the strongest first. `all`: gap conductances of any strength join groups without
/// this bound, so that clusters do not interact. A group is a set of bodies with one potential.
Clusters clusters_of(GroupNetwork network, int most, bool all = false);

/// Agglomerates as lists: sets of groups (bodies with one potential) that coarse grids treat as one
/// (../agglomerates.hpp). The lists may have more groups than the problem.
struct AgglomerateLists {
  /// By group: first group of its set.
  std::vector<int> first_group;
  /// Groups sorted by set; `start` [groups + 1]: by a set's first group, the index of its groups in `group`.
  std::vector<int> start, group;
  /// By group. `is_alone`: whether its set is one floating body; `held`: whether its set is grounded
  /// (Agglomerates::is_grounded).
  std::vector<int> is_alone, held;
};

/// Computes agglomerates (sets of groups that coarse grids treat as one) from couplings and the finest grid's direct
/// links (gap conductances). While sets with several groups have more than 300 groups that are unknowns of the coarsest
/// grid, weaker links are left out. `h`: cell size of the coarsest grid (m); `groups`: length of the lists. A group is
/// a set of bodies with one potential.
AgglomerateLists list_agglomerates(const LaplaceProblem& problem, std::vector<NetworkLink> links, double h, int groups);

}  // namespace lichtenberg::laplace::device
