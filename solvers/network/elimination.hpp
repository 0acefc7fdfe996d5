#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "solvers/network/dissection.hpp"
#include "solvers/network/network.hpp"
#include "solvers/parallel/team.hpp"

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
/// The fronts of a nested dissection are eliminated as dense blocks (multifrontal method, Duff & Reid 1983). Threads
/// share the subtrees of the dissection, and the products of the fronts above them; results have identical bits for any
/// number of threads.
class Elimination {
 public:
  /// Options of an elimination.
  struct Options {
    double bytes = std::numeric_limits<double>::infinity();       ///< Memory (bytes) that it may take
    double operations = std::numeric_limits<double>::infinity();  ///< Operations that it may take, two per product
    bool required = false;                                        ///< True if it is done even above these limits
    bool mesh_only = false;  ///< True if only mesh() is called: nothing is stored for the other results
    parallel::Team* team = &parallel::Team::single();  ///< Threads; must outlive the elimination
  };

  /// Eliminates all nodes of the network except `kept` (in any order, without duplicates). If that would exceed the
  /// limits of the options, nothing is eliminated and done() is false. Subtrees whose factors would exceed the memory
  /// are eliminated again when potentials() or resistances() need them. The network must outlive the elimination.
  Elimination(const Network& network, const std::vector<int>& kept, const Options& options);
  /// Eliminates all nodes of the network except `kept`, without limits of the cost.
  Elimination(const Network& network, const std::vector<int>& kept) : Elimination(network, kept, Options()) {}
  ~Elimination();
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

  /// Returns the number of matrix entries of the factor.
  std::int64_t entries() const { return entries_; }

 private:
  class Buffer;
  struct Block;
  struct Front;
  struct Results;
  struct Workspace;
  class Sizes;

  void find_blocks();
  void eliminate_all(const Sizes& sizes, bool stores_subtrees, bool stores_others);
  void eliminate(const Block& block, Results& results, Workspace& workspace, double* factor,
                 parallel::Team& team) const;
  void assemble(const Front& front, int children, Results& results, double* g, parallel::Team& team) const;
  double* factor_of(const Block& block, Workspace& workspace) const;
  void inject(double* x) const;
  void substitute(double* x) const;
  void substitute(const Block& block, double* factor, double* x) const;
  static void invert_stars(const Front& front, Eigen::MatrixXd& inverse);
  std::vector<int> parents() const;
  const Block& block_of(int front) const;

  /// Returns the node with the given number in the order of elimination; the kept nodes come last, in the order of
  /// `kept`.
  int node(int number) const { return dissection_.order[number]; }

  const Network& network_;
  parallel::Team& team_;
  int kept_;
  Incidence incidence_;
  Dissection dissection_;
  std::vector<int> number_;    ///< Number of each node in the order of elimination
  std::vector<Block> blocks_;  ///< In postorder
  Eigen::MatrixXd mesh_;
  std::int64_t entries_ = 0;
  bool done_ = false;
};

}  // namespace lichtenberg::network
