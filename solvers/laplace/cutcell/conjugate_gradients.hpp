#pragma once

#include <vector>

#include "solvers/laplace/cutcell/multigrid.hpp"
#include "solvers/laplace/cutcell/operator.hpp"

namespace lichtenberg::laplace {

/// Operator and preconditioner (Shell) and the vectors of the method below.
struct MatrixFreeContext {
  CutCellOperator* op = nullptr;
  Multigrid* multigrid = nullptr;
  bool null_space = false;      ///< nothing is grounded: the matrix takes constants to zero
  double applications = 0;      ///< of the operator, counted up
  std::vector<double> r, p, q;  ///< residual (of the first guess before the solve), direction, A p

  void multiply(const double* x, double* y) {
    op->apply(x, y);
    ++applications;
  }
  void precondition(const double* from, double* z) { multigrid->apply(from, z); }
};

/// KSP type: conjugate gradients as in KSPCG with the natural norm, but with the updates and products of vectors done
/// where the operator and the V-cycle have the rows at hand, and on all threads of the operator's team. It reads the
/// rows of x and b in place, needs the multigrid as PCSHELL with a MatrixFreeContext, and no other preconditioner.
inline constexpr const char* fused_cg = "cutcell";

/// Makes the type known to PETSc, which must be running. Throws Failure.
void register_fused_cg();

}  // namespace lichtenberg::laplace
