#pragma once

#include <vector>

#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

/// Link of a network: a conductance between nodes a and b.
struct NetworkLink {
  int a, b;
  double conductance;
};

/// Factorization of the conductance matrix of a network: the graph Laplacian of the links plus the nodes' conductances
/// to ground on the diagonal. The factors solve for potentials at given currents, or eliminate some of the nodes.
/// The elimination of a node adds links between its neighbours (star-mesh transformation) and distributes its ground
/// conductance among them. No step subtracts, so pivots keep all digits for any ratio of conductances (Alfa, Xue & Ye
/// 2002). A Cholesky factorization would keep four digits of nodes linked 1e12 times more strongly to each other than
/// to ground.
/// It is intended for some thousand nodes and repeated solves; solvers/network handles large networks between few
/// electrodes. Units: conductance times potential gives current (or capacitance, potential and charge).
class NetworkFactors {
 public:
  NetworkFactors() = default;
  /// Factorizes a network. `ground` [nodes]: conductance of each node to ground, not negative. `keep` [nodes]: true for
  /// nodes that are not eliminated; empty: all nodes are eliminated. Links of zero conductance are ignored.
  NetworkFactors(std::vector<double> ground, const std::vector<NetworkLink>& links, const std::vector<char>& keep = {});

  /// Solves for the potentials: replaces the current into each node, `flow` [nodes], by the node's potential. Only
  /// valid if all nodes are eliminated. In each connected part without a link to ground, one node gets potential zero.
  void solve(double* flow) const;
  /// Computes the inverse of the conductance matrix [nodes x nodes], by rows; only valid if all nodes are eliminated.
  /// Its entries are sums of positive terms and have all digits.
  std::vector<double> inverse() const;
  /// Forward elimination, the first part of solve(): distributes the currents into eliminated nodes among the kept
  /// nodes, in `flow` [nodes].
  void eliminate(double* flow) const;
  /// Back substitution, the last part of solve(): computes the potentials of the eliminated nodes. On entry `potential`
  /// [nodes] contains the potentials of kept nodes and, for eliminated nodes, the currents from eliminate().
  void substitute(double* potential) const;

  /// Returns the links between the kept nodes (Schur complement), including links that the elimination has added.
  std::vector<NetworkLink> kept_links() const;

 private:
  /// Neighbour of an eliminated node, and the fraction of the node's current that it receives.
  struct Share {
    int node;
    double fraction;
  };
  /// Elimination of one node: its pivot, and the index of its first Share.
  struct Step {
    int node;
    double pivot;
    std::size_t first_share;
  };
  std::vector<Step> steps_;
  std::vector<Share> shares_;
  std::vector<NetworkLink> kept_;
};

}  // namespace lichtenberg::laplace
