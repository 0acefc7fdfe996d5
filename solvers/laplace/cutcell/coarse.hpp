#pragma once

#include <cstdint>
#include <vector>

#include <cholmod.h>

#include "solvers/laplace/cutcell/level.hpp"
#include "solvers/laplace/cutcell/system.hpp"

namespace lichtenberg::laplace {

/// Sparse direct solver (Cholesky factorization, CHOLMOD) of the coarsest multigrid grid. The unknowns are the
/// potentials of fluid cells and of floating groups (bodies with one potential) that have an unknown on this grid.
class CoarseSolver {
 public:
  CoarseSolver();
  ~CoarseSolver();
  CoarseSolver(const CoarseSolver&) = delete;
  CoarseSolver& operator=(const CoarseSolver&) = delete;

  /// Factorizes a symmetric matrix, given by its upper triangle by columns. Throws Failure if the factorization fails,
  /// as for a matrix that is not positive definite. Without unknowns it only discards an earlier factorization. If the
  /// matrix has entries in the same rows and columns as the last one, the elimination order of the last one is used
  /// again.
  void factorize(SparseSystem system);
  /// Assembles and factorizes the system of the coarsest grid `level`. Throws Failure if the factorization fails. If no
  /// potential is given, the level of the potentials is fixed arbitrarily.
  void factorize(const LaplaceProblem& problem, const Level& level);
  /// Solves the system for the right-hand sides f (of cells, by slot) and `charge` (by group). Writes the potentials to
  /// v (by slot, the memory index) and phi (by group). Other entries, such as those of covered cells (inside
  /// conductors) and of groups of given potential, do not change. A group is a set of bodies with one potential.
  void solve(const float* f, const float* charge, float* v, float* phi);

 private:
  void release();
  cholmod_common common_;
  cholmod_factor* factor_ = nullptr;
  cholmod_dense* rhs_ = nullptr;
  cholmod_dense* solution_ = nullptr;
  cholmod_dense* work_y_ = nullptr;
  cholmod_dense* work_e_ = nullptr;
  SparseSystem system_;
};

}  // namespace lichtenberg::laplace
