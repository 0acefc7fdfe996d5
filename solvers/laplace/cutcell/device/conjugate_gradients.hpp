#pragma once

// PETSc's CG with its updates taken together: p = z + beta p in one pass, and x, r and the single-precision residual
// for the preconditioner in one. The products are PETSc's. As a KSP, so that the stop criterion, monitors and options
// are those of any other; -field_ksp_type cg takes PETSc's own.

#include "solvers/laplace/cutcell/fused_iteration.hpp"
#include "solvers/parallel/petsc.hpp"

namespace lichtenberg::laplace::device {

/// The parts of an iteration, on PETSc's vectors.
template <class Solver>
struct DeviceIteration {
  KSP ksp;
  Solver& solver;
  ::Vec r, z, p, q;

  PetscErrorCode precondition(double* product) {
    solver.precondition_taken(z);  // the residual that the last update has left
    Mat matrix = nullptr;
    PetscCall(KSPGetOperators(ksp, &matrix, nullptr));
    MatNullSpace space = nullptr;
    PetscCall(MatGetNullSpace(matrix, &space));
    if (space) PetscCall(MatNullSpaceRemove(space, z));
    return VecDot(r, z, product);
  }
  PetscErrorCode turn(double beta, double* curvature) {
    solver.turn(z, beta, p, q);
    return VecDot(p, q, curvature);
  }
  PetscErrorCode step(double alpha) {
    solver.step(alpha, p, q, ksp->vec_sol, r);
    return 0;
  }
};

template <class Solver>
PetscErrorCode solve_by_conjugate_gradients(KSP ksp) {
  Solver* solver = nullptr;
  PetscCall(PCShellGetContext(ksp->pc, &solver));
  DeviceIteration<Solver> iteration{ksp, *solver, ksp->work[0], ksp->work[1], ksp->work[2], ksp->work[3]};
  solver->start(ksp->vec_rhs, ksp->vec_sol, iteration.r, iteration.q);
  return iterate(ksp, iteration);
}

/// Registers the method under `name`; its preconditioner must be a shell whose context is a Solver.
template <class Solver>
void register_conjugate_gradients(const char* name) {
  parallel::check_petsc(KSPRegister(name, [](KSP ksp) -> PetscErrorCode {
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
