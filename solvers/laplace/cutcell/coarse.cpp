#include "solvers/laplace/cutcell/coarse.hpp"

#include "solvers/error.hpp"
#include "solvers/laplace/cutcell/system.hpp"

namespace lichtenberg::laplace {

CoarseSolver::CoarseSolver() {
  cholmod_start(&common_);
  common_.nmethods = 1;  // AMD only: comparing orderings is too expensive for so small a matrix
  common_.method[0].ordering = CHOLMOD_AMD;
  common_.print = 0;
#ifdef LICHTENBERG_REPEATABLE
  common_.supernodal = CHOLMOD_SIMPLICIAL;  // the other factorization uses BLAS
#endif
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
  factorize(assemble(problem, level, true, !problem.has_ground()));
}

void CoarseSolver::factorize(SparseSystem system) {
  const bool same_entries = factor_ && system.start == system_.start && system.index == system_.index;
  system_ = std::move(system);
  if (!same_entries) release();
  if (system_.unknowns() == 0) return;  // all cells are covered by conductors of given potential
  cholmod_sparse matrix{};
  matrix.nrow = matrix.ncol = system_.unknowns();
  matrix.nzmax = system_.index.size();
  matrix.p = system_.start.data();
  matrix.i = system_.index.data();
  matrix.x = system_.value.data();
  matrix.stype = 1;  // upper triangle by columns
  matrix.itype = CHOLMOD_INT;
  matrix.xtype = CHOLMOD_REAL;
  matrix.dtype = CHOLMOD_DOUBLE;
  matrix.sorted = matrix.packed = 1;
  if (!same_entries) {  // the analysis takes most of the time
    factor_ = cholmod_analyze(&matrix, &common_);
    rhs_ = cholmod_zeros(matrix.nrow, 1, CHOLMOD_REAL, &common_);
  }
  if (!factor_ || !cholmod_factorize(&matrix, factor_, &common_) || common_.status != CHOLMOD_OK) {
    release();
    throw Failure(
        "field solver: the Cholesky factorization of the coarsest grid failed (a conductor without any link?)");
  }
}

void CoarseSolver::solve(const float* f, const float* charge, float* v, float* phi) {
  if (!factor_) return;
  double* rhs = static_cast<double*>(rhs_->x);
  const std::size_t cells = system_.slot.size();
  for (std::size_t a = 0; a < cells; ++a) rhs[a] = f[system_.slot[a]];
  for (std::size_t g = 0; g < system_.group.size(); ++g) rhs[cells + g] = charge[system_.group[g]];
  system_.from_charges(rhs);
  cholmod_solve2(CHOLMOD_A, factor_, rhs_, nullptr, &solution_, nullptr, &work_y_, &work_e_, &common_);
  double* x = static_cast<double*>(solution_->x);
  system_.to_potentials(x);
  for (std::size_t a = 0; a < cells; ++a) v[system_.slot[a]] = static_cast<float>(x[a]);
  for (std::size_t g = 0; g < system_.group.size(); ++g) phi[system_.group[g]] = static_cast<float>(x[cells + g]);
}

}  // namespace lichtenberg::laplace
