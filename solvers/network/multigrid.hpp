#pragma once

#include <vector>

#include "solvers/network/network.hpp"

namespace lichtenberg::network {

struct MultigridSolution {
  std::vector<double> potential;  ///< Potential of each node (V), [nodes]
  int iterations = 0;
  int levels = 0;
  /// Sum over the nodes of the unbalanced currents (A). The conductance computed from the power exceeds the true one by
  /// at most this over the voltage. For potential errors e, |e| <= voltage, the excess of the power is e^T S e = e^T (S
  /// e).
  double imbalance = 0;
};

/// Solves for the potentials with node `low` at 0 and node `high` at `voltage` (V), by conjugate gradients with an
/// algebraic multigrid preconditioner. Memory and work grow with the number of links. A coarse level merges nodes in
/// pairs of strong links, twice, and is a network again. Two flexible conjugate gradient steps on each level compensate
/// for the plain merging (Notay 2010, "An aggregation-based algebraic multigrid method"). All nodes must have a path to
/// the electrodes. Stops when the imbalance is at most `tolerance` times the current.
/// The accuracy of the potentials depends on the condition of the matrix: for conductances over many decades use the
/// elimination. Throws Failure if 200 iterations do not suffice.
MultigridSolution solve_by_multigrid(const Network& network, int low, int high, double voltage, double tolerance);

}  // namespace lichtenberg::network
