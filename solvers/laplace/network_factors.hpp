#pragma once

#include <utility>
#include <vector>

#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

/// Conductance between two nodes.
struct NetworkLink {
  int a, b;
  double conductance;
};

/// Factorization of a network of conductances, some of its nodes linked to ground: diag(ground) + the graph Laplacian
/// of the links. Eliminating a node puts links between its neighbours (star-mesh transformation), and what it had to
/// ground is theirs in parts. Nothing is ever subtracted, so that pivots keep all digits whatever lies between the
/// weakest conductance and the strongest (Alfa, Xue & Ye 2002): with a Cholesky factorization, nodes linked a 1e12
/// times more strongly to each other than to ground would keep four. For some thousand nodes with grounds, over and
/// over; large networks between a few electrodes are the room solvers/network's.
class NetworkFactors {
 public:
  NetworkFactors() = default;
  /// ground [nodes], not negative; nodes that `keep` marks are not eliminated (empty: all are). Links of no conductance
  /// are left out.
  NetworkFactors(std::vector<double> ground, const std::vector<NetworkLink>& links, const std::vector<char>& keep = {});

  /// Takes what flows into each node to its potential. Nodes that are linked to no ground: one of each set of them gets
  /// zero.
  void solve(double* flow) const;
  /// By rows, what solve() multiplies with where all nodes are eliminated: sums of positive terms, so that entries have
  /// all digits.
  std::vector<double> inverse() const;
  /// The parts of it: shares of what flows into eliminated nodes to those that are kept, and back with their
  /// potentials.
  void eliminate(double* flow) const;
  void substitute(double* potential) const;

  /// Between nodes that are kept, those that elimination has made among them.
  std::vector<NetworkLink> kept_links() const;

 private:
  struct Share {
    int node;
    double of_flow;
  };
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
