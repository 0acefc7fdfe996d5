#pragma once

#include <vector>

#include "solvers/network/network.hpp"

namespace lichtenberg::network {

struct MultigridSolution {
  std::vector<double> potential;  ///< [nodes] V
  int iterations = 0;
  int levels = 0;
  /// A, sum over the nodes of the currents that do not balance. The conductance from the power exceeds the true one by
  /// at most this over the voltage: the excess is e^T S e = e^T (S e) for potentials wrong by e, |e| <= voltage.
  double imbalance = 0;
};

/// Potentials with node `low` at 0 and node `high` at `voltage` (V), by conjugate gradients with an algebraic multigrid
/// preconditioner: memory and work grow with the number of links. A coarse level is the network with its nodes merged
/// in pairs of strong links, twice, and so a network again; two flexible conjugate gradient steps on each level make up
/// for the plain merging (Notay 2010, "An aggregation-based algebraic multigrid method"). All nodes must be joined to
/// the electrodes. Stops when the imbalance is at most `tolerance` times the current.
///
/// Its potentials are as good as the conditioning of the matrix allows: for conductances over many decades use the
/// elimination. Throws Failure if 200 iterations do not suffice.
MultigridSolution solve_by_multigrid(const Network& network, int low, int high, double voltage, double tolerance);

}  // namespace lichtenberg::network
