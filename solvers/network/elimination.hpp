#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <vector>

#include "solvers/network/dissection.hpp"
#include "solvers/network/network.hpp"

namespace lichtenberg::network {

/// Direct solver for resistor networks: star-mesh elimination of all nodes except some kept nodes (static condensation,
/// Kron reduction). Every node must have a path to a kept node.
/// The elimination of node k replaces its star of conductances g_kj by a mesh: g_ij += g_ki g_kj / s_k with s_k = sum_j
/// g_kj. This is a step of Cholesky's factorization of the conductance matrix S. The result is the Schur complement
/// S_cc - S_ce S_ee^-1 S_ec (c: kept, e: eliminated nodes).
/// In contrast to Cholesky's method, the pivot s_k is summed from the off-diagonal entries (Grassmann, Taksar & Heyman
/// 1985). No step subtracts. Each resulting conductance therefore has a small relative error for any ratio of
/// conductances, even 1e60 (O'Cinneide 1993; Alfa, Xue & Ye 2002). A pivot from which Cholesky's method subtracts loses
/// all digits at a ratio of 1e16.
/// The fronts of a nested dissection are eliminated in sequence as dense blocks (multifrontal method, Duff & Reid
/// 1983).
class Elimination {
 public:
  /// Upper limits of the cost of an elimination: memory (bytes) and number of floating-point operations.
  struct Limits {
    double bytes = std::numeric_limits<double>::infinity(), operations = std::numeric_limits<double>::infinity();
  };

  /// Eliminates all nodes of the network except `kept` (in any order, without duplicates). If that would exceed the
  /// limits, nothing is eliminated and done() is false.
  Elimination(const Network& network, const std::vector<int>& kept, const Limits& limits);
  /// Eliminates all nodes of the network except `kept`, without limits of the cost.
  Elimination(const Network& network, const std::vector<int>& kept) : Elimination(network, kept, Limits()) {}
  /// Returns true if the nodes are eliminated; false if the limits excluded it, so that there are no results.
  bool done() const { return done_; }

  /// Returns the conductances (S) [kept, kept] between the kept nodes in the equivalent network, in the order of
  /// `kept`, with zero diagonal. The reduced conductance matrix (Schur complement) has their negatives off the
  /// diagonal, and the sums of their rows on it.
  const Eigen::MatrixXd& mesh() const { return mesh_; }

  /// Computes the potentials (V) of all nodes [nodes, m] for m right-hand sides. `kept_potential`: [kept, m] potentials
  /// of the kept nodes (V). `injected`: [nodes, m] currents injected at the other nodes (A), or empty for none.
  Eigen::MatrixXd potentials(const Eigen::MatrixXd& kept_potential, const Eigen::MatrixXd& injected = {}) const;

  /// Computes the effective resistance (Ohm) between each node and the kept nodes, short-circuited with each other:
  /// [nodes], zero for kept nodes.
  /// The results are the diagonal of the inverse of the conductance matrix with the kept nodes grounded. Only entries
  /// of the inverse within fronts are computed (selected inversion, Erisman & Tinney 1975), with about twice the
  /// operations of the elimination. All sums are of positive numbers.
  Eigen::VectorXd resistances() const;

  /// Returns the number of matrix entries that the elimination stores.
  std::int64_t stored_entries() const { return static_cast<std::int64_t>(factor_.size()); }
  double operations() const { return operations_; }  ///< Operations of the elimination: two per multiplication

 private:
  struct ForwardLinks;
  struct Update;
  class Run;

  /// Returns the number of nodes that a front eliminates.
  int size(int front) const { return dissection_.fronts[front].last - dissection_.fronts[front].first; }
  /// Returns the number of later nodes that are linked to a front's nodes at its elimination.
  int border(int front) const { return border_start_[front + 1] - border_start_[front]; }
  void invert_stars(int front, Eigen::MatrixXd& inverse) const;
  std::vector<int> parents() const;

  /// Returns the node with the given number in the order of elimination; the kept nodes come last, in the order of
  /// `kept`.
  int node(int number) const { return dissection_.order[number]; }

  int nodes_, kept_;
  Dissection dissection_;
  std::vector<int> border_start_, border_;  ///< Per front: the later nodes that its elimination joins, ascending
  std::vector<std::int64_t> factor_start_;  ///< Start of each front in factor_
  std::vector<double> factor_;  ///< Per front: columns [size + border] of its nodes, with s_k on the diagonal
  Eigen::MatrixXd mesh_;
  double operations_ = 0;
  bool done_ = false;
};

}  // namespace lichtenberg::network
