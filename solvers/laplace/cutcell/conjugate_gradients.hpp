#pragma once

#include <vector>

#include "solvers/laplace/cutcell/multigrid.hpp"
#include "solvers/laplace/cutcell/operator.hpp"

namespace lichtenberg::laplace {

/// Operator, preconditioner and work vectors of conjugate gradients without a matrix; the context of PETSc's shell
/// objects (Shell).
struct MatrixFreeContext {
  CutCellOperator* op = nullptr;
  Multigrid* multigrid = nullptr;
  bool null_space = false;  ///< nothing is grounded: the matrix maps constants to zero
  double applications = 0;  ///< number of operator evaluations
  SplitVector r, p, q;      ///< residual (before the solve: of the initial guess), direction, A p

  /// Computes y = A x and counts the evaluation.
  void multiply(const double* x, double* y) {
    op->apply(x, y);
    ++applications;
  }
  /// Applies the preconditioner to `from`: one multigrid V-cycle. The result is z.
  void precondition(const double* from, double* z) { multigrid->apply(from, z); }
};

/// Name of a PETSc KSP type: conjugate gradients with the iterates of KSPCG and the natural norm, except for rounding.
/// They may end one V-cycle earlier, by a predicted norm. Updates and products of vectors are computed row by row
/// together with the operator and the V-cycle, on the threads of the operator's team. Residual and direction of cells
/// are stored in single precision, but the sums of A p are in double precision. Whenever the norm has fallen by three
/// decades, the iteration starts again from the residual of x. The rounding of a residual next to a conductor of large
/// conductance acts as a charge on it, with a norm of up to 1e-5 of the first. The type accesses x and b in place. Its
/// preconditioner must be the multigrid, a PCSHELL with a MatrixFreeContext.
inline constexpr const char* fused_cg = "cutcell";

/// Registers the conjugate gradients `fused_cg` with PETSc, which must be running. Throws Failure if PETSc reports an
/// error.
void register_fused_cg();

}  // namespace lichtenberg::laplace
