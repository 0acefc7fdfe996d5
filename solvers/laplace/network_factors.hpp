#pragma once

#include <vector>

#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

/// Conductance between two nodes.
struct NetworkLink {
  int a, b;
  double conductance;
};

/// Factorization of a network of conductances with some nodes linked to ground: diag(ground) + the graph Laplacian of
/// the links. Eliminating a node adds links between its neighbours (star-mesh transformation), and its ground
/// conductance is distributed among them. No step subtracts, so pivots keep all digits for any ratio of conductances
/// (Alfa, Xue & Ye 2002). A Cholesky factorization would keep four digits of nodes linked 1e12 times more strongly to
/// each other than to ground. Intended for some thousand nodes and repeated solves; solvers/network handles large
/// networks between few electrodes.
class NetworkFactors {
 public:
  NetworkFactors() = default;
  /// Factorizes a network. `ground` [nodes]: not negative; nodes marked in `keep` are not eliminated (empty: all are).
  /// Links of zero conductance are ignored.
  NetworkFactors(std::vector<double> ground, const std::vector<NetworkLink>& links, const std::vector<char>& keep = {});

  /// Replaces the current into each node by its potential. Of each set of nodes without a link to ground, one gets
  /// potential zero.
  void solve(double* flow) const;
  /// Returns the matrix, by rows, that solve() applies if all nodes are eliminated. Its entries are sums of positive
  /// terms and have all digits.
  std::vector<double> inverse() const;
  /// First part of solve(): distributes the current into eliminated nodes among the kept ones.
  void eliminate(double* flow) const;
  /// Last part of solve(): computes the potentials of eliminated nodes from those of the kept ones.
  void substitute(double* potential) const;

  /// Returns the links between kept nodes, including those that elimination has added.
  std::vector<NetworkLink> kept_links() const;

 private:
  struct Share {
    int node;
    double fraction;
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
