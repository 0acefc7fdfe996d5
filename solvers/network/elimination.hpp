#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <vector>

#include "solvers/network/dissection.hpp"
#include "solvers/network/network.hpp"

namespace lichtenberg::network {

/// Static condensation of a network to some of its nodes, by star-mesh elimination.
///
/// To eliminate a node is to replace its star of conductances g_kj by a mesh: g_ij += g_ki g_kj / s_k, s_k = sum_j
/// g_kj. That is Cholesky's step on the conductance matrix, the Schur complement S_kk - S_ke S_ee^-1 S_ek at the end,
/// except that the pivot s_k is summed from the off-diagonal entries and not updated (Grassmann, Taksar & Heyman 1985).
/// So nothing is ever subtracted, and each conductance of the condensed network has a small *relative* error whatever
/// the ratio of the conductances (O'Cinneide 1993; Alfa, Xue & Ye 2002): 1e-30 and 1e30 in one network are as good as
/// any. An updated pivot loses its digits already at a ratio of 1e16.
///
/// The fronts of a nested dissection are eliminated one after the other as dense blocks (the multifrontal method, Duff
/// & Reid 1983). Every node must be joined to a kept one by some path.
class Elimination {
 public:
  /// What an elimination may cost.
  struct Limits {
    double bytes = std::numeric_limits<double>::infinity(), operations = std::numeric_limits<double>::infinity();
  };

  /// `kept`: the nodes that stay, in any order, none twice. Nothing is eliminated beyond the limits.
  Elimination(const Network& network, const std::vector<int>& kept, const Limits& limits);
  Elimination(const Network& network, const std::vector<int>& kept) : Elimination(network, kept, Limits()) {}
  /// False if it would have exceeded its limits: then there are no results.
  bool done() const { return done_; }

  /// [kept, kept] conductances (S) of the condensed network, in the order of `kept`; zero diagonal. The reduced
  /// conductance matrix has these with a minus sign, and their sums on the diagonal.
  const Eigen::MatrixXd& mesh() const { return mesh_; }

  /// Potentials (V) of all nodes, one column a right-hand side. `given`: [kept, m] potentials of the kept nodes (V);
  /// `fed`: [nodes, m] currents fed into the other nodes (A), or empty for none.
  Eigen::MatrixXd potentials(const Eigen::MatrixXd& given, const Eigen::MatrixXd& fed = {}) const;

  /// Effective resistances (Ohm) between each node, [nodes], and the kept ones, which are joined to one; zero for
  /// those. The diagonal of the inverse of the grounded conductance matrix, by the entries of the inverse that lie in
  /// the fronts alone (Erisman & Tinney 1975), at twice the operations of the elimination. Only sums of positive
  /// numbers.
  Eigen::VectorXd resistances() const;

  std::int64_t stored_entries() const { return static_cast<std::int64_t>(factor_.size()); }
  double operations() const { return operations_; }  ///< multiplications, twice, of the elimination

 private:
  struct Later;
  struct Update;
  class Run;

  int size(int front) const { return dissection_.fronts[front].last - dissection_.fronts[front].first; }
  int border(int front) const { return border_start_[front + 1] - border_start_[front]; }
  void invert_stars(int front, Eigen::MatrixXd& inverse) const;
  std::vector<int> parents() const;

  /// A node by its number in the order of elimination; kept ones in the order of `kept`.
  int node(int number) const { return dissection_.order[number]; }

  int nodes_, kept_;
  Dissection dissection_;
  std::vector<int> border_start_, border_;  ///< by front: the later nodes that its elimination joins, ascending
  std::vector<std::int64_t> factor_start_;  ///< by front
  std::vector<double> factor_;              ///< by front: columns [size + border] of a front's nodes; s_k as diagonal
  Eigen::MatrixXd mesh_;
  double operations_ = 0;
  bool done_ = false;
};

}  // namespace lichtenberg::network
