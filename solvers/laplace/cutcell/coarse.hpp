#pragma once

#include <cstdint>
#include <vector>

#include <cholmod.h>

#include "solvers/laplace/cutcell/level.hpp"
#include "solvers/laplace/cutcell/system.hpp"

namespace lichtenberg::laplace {

/// Sparse Cholesky factorization (CHOLMOD) of the coarsest grid's system of fluid cells and floating groups.
class CoarseSolver {
 public:
  CoarseSolver();
  ~CoarseSolver();
  CoarseSolver(const CoarseSolver&) = delete;
  CoarseSolver& operator=(const CoarseSolver&) = delete;

  /// Factorizes a matrix, given by its upper triangle by columns. Throws Failure if it is not positive definite within
  /// rounding.
  void factorize(SparseSystem system);
  void factorize(const LaplaceProblem& problem, const Level& level);
  /// Solves the system for the right-hand sides f (of cells) and charge (of groups). Writes the solution to v (by
  /// Layout slot) and phi (by group). Entries of fixed groups and covered cells are not changed.
  void solve(const float* f, const float* charge, float* v, float* phi);

 private:
  void release();
  cholmod_common common_;
  cholmod_factor* factor_ = nullptr;
  cholmod_dense* rhs_ = nullptr;
  cholmod_dense* solution_ = nullptr;
  cholmod_dense* work_y_ = nullptr;
  cholmod_dense* work_e_ = nullptr;
  // The numbering only, without rows.
  SparseSystem system_;
};

}  // namespace lichtenberg::laplace
