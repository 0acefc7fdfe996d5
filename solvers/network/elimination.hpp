#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <vector>

#include "solvers/network/dissection.hpp"
#include "solvers/network/network.hpp"

namespace lichtenberg::network {

/// Static condensation of a network to some of its nodes, by star-mesh elimination.
/// The elimination of a node replaces its star of conductances g_kj by a mesh: g_ij += g_ki g_kj / s_k, s_k = sum_j
/// g_kj. It is Cholesky's step on the conductance matrix, with the Schur complement S_kk - S_ke S_ee^-1 S_ek as the
/// result. But the pivot s_k is summed from the off-diagonal entries and not updated (Grassmann, Taksar & Heyman 1985).
/// No step subtracts, so each conductance of the condensed network has a small relative error for any ratio of
/// conductances, even 1e-30 to 1e30 (O'Cinneide 1993; Alfa, Xue & Ye 2002). An updated pivot loses its digits at a
/// ratio of 1e16.
/// The fronts of a nested dissection are eliminated in sequence as dense blocks (multifrontal method, Duff & Reid
/// 1983). Every node must have a path to a kept one.
class Elimination {
 public:
  /// Upper bounds on the cost of an elimination.
  struct Limits {
    double bytes = std::numeric_limits<double>::infinity(), operations = std::numeric_limits<double>::infinity();
  };

  /// Eliminates all nodes except `kept`, which may be in any order, without duplicates. Stops before the elimination if
  /// it would exceed the limits.
  Elimination(const Network& network, const std::vector<int>& kept, const Limits& limits);
  Elimination(const Network& network, const std::vector<int>& kept) : Elimination(network, kept, Limits()) {}
  /// Returns false if the limits were exceeded, without results.
  bool done() const { return done_; }

  /// Returns the conductances (S) [kept, kept] of the condensed network, in the order of `kept`, with zero diagonal.
  /// The reduced conductance matrix has these with a minus sign, and their sums on the diagonal.
  const Eigen::MatrixXd& mesh() const { return mesh_; }

  /// Returns the potentials (V) of all nodes, one column per right-hand side. `kept_potential`: [kept, m] potentials of
  /// the kept nodes (V); `injected`: [nodes, m] injected currents at the other nodes (A), or empty for none.
  Eigen::MatrixXd potentials(const Eigen::MatrixXd& kept_potential, const Eigen::MatrixXd& injected = {}) const;

  /// Returns the effective resistances (Ohm) between each node, [nodes], and the kept nodes, which are connected to
  /// each other; zero for kept nodes. They are the diagonal of the inverse of the grounded conductance matrix. Only the
  /// entries of the inverse within the fronts are computed (Erisman & Tinney 1975), with twice the operations of the
  /// elimination. All sums are of positive numbers.
  Eigen::VectorXd resistances() const;

  std::int64_t stored_entries() const { return static_cast<std::int64_t>(factor_.size()); }
  double operations() const { return operations_; }  ///< Operations of the elimination: two per multiplication

 private:
  struct ForwardLinks;
  struct Update;
  class Run;

  int size(int front) const { return dissection_.fronts[front].last - dissection_.fronts[front].first; }
  int border(int front) const { return border_start_[front + 1] - border_start_[front]; }
  void invert_stars(int front, Eigen::MatrixXd& inverse) const;
  std::vector<int> parents() const;

  /// Returns the node with a number in the order of elimination; kept nodes are in the order of `kept`.
  int node(int number) const { return dissection_.order[number]; }

  int nodes_, kept_;
  Dissection dissection_;
  std::vector<int> border_start_, border_;  ///< Per front: the later nodes that its elimination joins, ascending
  std::vector<std::int64_t> factor_start_;  ///< Start of each front in factor_
  std::vector<double> factor_;              ///< Per front: columns [size + border] of its nodes, with s_k on the
                                            ///< diagonal
  Eigen::MatrixXd mesh_;
  double operations_ = 0;
  bool done_ = false;
};

}  // namespace lichtenberg::network
