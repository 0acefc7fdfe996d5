#include "solvers/laplace/cutcell/coarse.hpp"

#include "solvers/error.hpp"
#include "solvers/laplace/cutcell/system.hpp"

namespace lichtenberg::laplace {

CoarseSolver::CoarseSolver() {
  cholmod_start(&common_);
  common_.nmethods = 1;  // AMD alone: trying several orderings costs more than they save on so small a matrix
  common_.method[0].ordering = CHOLMOD_AMD;
  common_.print = 0;
}

CoarseSolver::~CoarseSolver() {
  release();
  cholmod_finish(&common_);
}

void CoarseSolver::release() {
  cholmod_free_factor(&factor_, &common_);
  cholmod_free_dense(&rhs_, &common_);
  cholmod_free_dense(&solution_, &common_);
  cholmod_free_dense(&work_y_, &common_);
  cholmod_free_dense(&work_e_, &common_);
}

void CoarseSolver::factorize(const LaplaceProblem& problem, const Level& level) {
  release();
  SparseSystem system = assemble(problem, level, true, !problem.has_ground());
  cholmod_sparse matrix{};
  matrix.nrow = matrix.ncol = system.unknowns();
  matrix.nzmax = system.index.size();
  matrix.p = system.start.data();
  matrix.i = system.index.data();
  matrix.x = system.value.data();
  matrix.stype = 1;  // row a holds the columns b <= a: the upper triangle by columns
  matrix.itype = CHOLMOD_INT;
  matrix.xtype = CHOLMOD_REAL;
  matrix.dtype = CHOLMOD_DOUBLE;
  matrix.sorted = matrix.packed = 1;
  factor_ = cholmod_analyze(&matrix, &common_);
  if (!factor_ || !cholmod_factorize(&matrix, factor_, &common_) || common_.status != CHOLMOD_OK)
    throw Failure(
        "field solver: the Cholesky factorization of the coarsest grid failed (a conductor without any link?)");
  rhs_ = cholmod_zeros(matrix.nrow, 1, CHOLMOD_REAL, &common_);
  slot_ = std::move(system.slot);
  group_ = std::move(system.group);
}

void CoarseSolver::solve(const float* f, const float* charge, float* v, float* phi) {
  double* rhs = static_cast<double*>(rhs_->x);
  const std::size_t cells = slot_.size();
  for (std::size_t a = 0; a < cells; ++a) rhs[a] = f[slot_[a]];
  for (std::size_t g = 0; g < group_.size(); ++g) rhs[cells + g] = charge[group_[g]];
  cholmod_solve2(CHOLMOD_A, factor_, rhs_, nullptr, &solution_, nullptr, &work_y_, &work_e_, &common_);
  const double* x = static_cast<const double*>(solution_->x);
  for (std::size_t a = 0; a < cells; ++a) v[slot_[a]] = static_cast<float>(x[a]);
  for (std::size_t g = 0; g < group_.size(); ++g) phi[group_[g]] = static_cast<float>(x[cells + g]);
}

}  // namespace lichtenberg::laplace
