#pragma once

// PETSc's CG with its updates taken together: p = z + beta p in one pass, and x, r and the single-precision residual
// for the preconditioner in one. The products are PETSc's. As a KSP, so that the stop criterion, monitors and options
// are those of any other; -field_ksp_type cg takes PETSc's own.

#include <petsc/private/kspimpl.h>

#include <cmath>

#include "solvers/laplace/cutcell/petsc.hpp"

namespace lichtenberg::laplace::device {

/// Reports the natural norm squared to monitors, history and the stop criterion.
inline PetscErrorCode report(KSP ksp, double squared) {
  ksp->rnorm = std::sqrt(std::abs(squared));
  PetscCall(KSPLogResidualHistory(ksp, ksp->rnorm));
  PetscCall(KSPMonitor(ksp, ksp->its, ksp->rnorm));
  PetscCall((*ksp->converged)(ksp, ksp->its, ksp->rnorm, &ksp->reason, ksp->cnvP));
  return 0;
}

/// z = M r for the residual that the last update has left; returns r'z.
template <class Solver>
PetscErrorCode precondition_and_multiply(KSP ksp, Solver& solver, Vec r, Vec z, double* product) {
  solver.precondition_taken(z);
  Mat matrix = nullptr;
  PetscCall(KSPGetOperators(ksp, &matrix, nullptr));
  MatNullSpace space = nullptr;
  PetscCall(MatGetNullSpace(matrix, &space));
  if (space) PetscCall(MatNullSpaceRemove(space, z));
  PetscCall(VecDot(r, z, product));
  return 0;
}

template <class Solver>
PetscErrorCode solve_by_conjugate_gradients(KSP ksp) {
  Solver* solver = nullptr;
  PetscCall(PCShellGetContext(ksp->pc, &solver));
  const Vec r = ksp->work[0], z = ksp->work[1], p = ksp->work[2], q = ksp->work[3];
  double product = 0, beta = 0, curvature = 0;
  ksp->its = 0;
  solver->start(ksp->vec_rhs, ksp->vec_sol, r, q);
  PetscCall(precondition_and_multiply(ksp, *solver, r, z, &product));
  PetscCall(report(ksp, product));
  while (!ksp->reason && ksp->its < ksp->max_it) {
    solver->turn(z, beta, p, q);
    PetscCall(VecDot(p, q, &curvature));
    if (!(curvature > 0)) {
      ksp->reason = KSP_DIVERGED_INDEFINITE_MAT;
      break;
    }
    solver->step(product / curvature, p, q, ksp->vec_sol, r);
    const double last = product;
    PetscCall(precondition_and_multiply(ksp, *solver, r, z, &product));
    ++ksp->its;
    if (product < 0) {
      ksp->reason = KSP_DIVERGED_INDEFINITE_PC;
      break;
    }
    beta = product / last;
    PetscCall(report(ksp, product));
  }
  if (!ksp->reason) ksp->reason = KSP_DIVERGED_ITS;
  return 0;
}

/// Registers the method under `name`; its preconditioner must be a shell whose context is a Solver.
template <class Solver>
void register_conjugate_gradients(const char* name) {
  check_petsc(KSPRegister(name, [](KSP ksp) -> PetscErrorCode {
    PetscCall(KSPSetSupportedNorm(ksp, KSP_NORM_NATURAL, PC_LEFT, 3));
    ksp->ops->setup = [](KSP method) -> PetscErrorCode { return KSPSetWorkVecs(method, 4); };
    ksp->ops->solve = solve_by_conjugate_gradients<Solver>;
    ksp->ops->destroy = KSPDestroyDefault;
    ksp->ops->buildsolution = KSPBuildSolutionDefault;
    ksp->ops->buildresidual = KSPBuildResidualDefault;
    return 0;
  }));
}

}  // namespace lichtenberg::laplace::device
