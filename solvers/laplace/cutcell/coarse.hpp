#pragma once

#include <cstdint>
#include <vector>

#include <cholmod.h>

#include "solvers/laplace/cutcell/level.hpp"
#include "solvers/laplace/cutcell/system.hpp"

namespace lichtenberg::laplace {

/// Sparse Cholesky factorization (CHOLMOD) of a coarsest grid's system: fluid cells and floating groups.
class CoarseSolver {
 public:
  CoarseSolver();
  ~CoarseSolver();
  CoarseSolver(const CoarseSolver&) = delete;
  CoarseSolver& operator=(const CoarseSolver&) = delete;

  /// `system`: its upper triangle by columns. Throws Failure if the matrix is not positive definite to working
  /// precision.
  void factorize(SparseSystem system);
  void factorize(const LaplaceProblem& problem, const Level& level);
  /// v (by slot) and phi (by group) from f and charge; entries of fixed groups and covered cells are left as they are.
  void solve(const float* f, const float* charge, float* v, float* phi);

 private:
  void release();
  cholmod_common common_;
  cholmod_factor* factor_ = nullptr;
  cholmod_dense* rhs_ = nullptr;
  cholmod_dense* solution_ = nullptr;
  cholmod_dense* work_y_ = nullptr;
  cholmod_dense* work_e_ = nullptr;
  SparseSystem system_;  // its numbering only
};

}  // namespace lichtenberg::laplace
