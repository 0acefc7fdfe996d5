#pragma once

#include <vector>

#include "solvers/network/network.hpp"

namespace lichtenberg::network {

/// Result of solve_by_multigrid(): the potentials and their accuracy.
struct MultigridSolution {
  std::vector<double> potential;  ///< Potential of each node (V), [nodes]
  int iterations = 0;             ///< Conjugate gradient iterations
  int levels = 0;                 ///< Levels of the multigrid, including the finest one
  bool converged = true;          ///< False if 200 iterations have not reached the tolerance
  /// Residual: sum over the nodes of the magnitudes of unbalanced currents (A). The conductance computed from the power
  /// exceeds the true conductance by at most imbalance / voltage. The reason: potential errors e, |e| <= voltage,
  /// increase the power by e^T (S e), with the conductance matrix S and the unbalanced currents S e.
  double imbalance = 0;
};

/// Computes the potentials of a resistor network with node `low` at 0 and node `high` at `voltage` (V), by conjugate
/// gradients with an aggregation multigrid preconditioner. All nodes must have a path to the electrodes `low` and
/// `high`.
/// A coarse level merges nodes in pairs of strong links, twice, and is a network again. One or two flexible conjugate
/// gradient steps on each intermediate level (K-cycle) compensate for the plain merging (Notay 2010, "An
/// aggregation-based algebraic multigrid method"). Memory and work grow with the number of links.
/// Iteration stops when the imbalance is at most `tolerance` times the current, or after 200 iterations.
/// The error of the potentials grows with the condition number of the matrix: for conductances over many decades use
/// Elimination.
MultigridSolution solve_by_multigrid(const Network& network, int low, int high, double voltage, double tolerance);

}  // namespace lichtenberg::network
