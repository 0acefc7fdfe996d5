#pragma once

#include <petsc/private/kspimpl.h>

#include <cmath>

#include "solvers/laplace/cutcell/krylov.hpp"
#include "solvers/parallel/petsc.hpp"

namespace lichtenberg::laplace {

/// Registers the function solve(KSP) with PETSc as a Krylov method `name` that computes the natural norm sqrt(r' M r)
/// of the residual r (M: preconditioner). Throws Failure if PETSc reports an error.
template <PetscErrorCode (*solve)(KSP)>
void register_natural_method(const char* name) {
  parallel::check_petsc(KSPRegister(name, [](KSP ksp) -> PetscErrorCode {
    PetscCall(KSPSetSupportedNorm(ksp, KSP_NORM_NATURAL, PC_LEFT, 3));
    ksp->ops->setup = [](KSP) -> PetscErrorCode { return 0; };
    ksp->ops->solve = solve;
    ksp->ops->destroy = KSPDestroyDefault;
    ksp->ops->buildsolution = KSPBuildSolutionDefault;
    ksp->ops->buildresidual = KSPBuildResidualDefault;
    return 0;
  }));
}

/// Passes a residual norm to PETSc's monitors, the residual history and the stop criterion, which may end the
/// iterations. `squared`: square of the natural norm sqrt(r' M r) of the residual r (M: preconditioner).
inline PetscErrorCode report_norm(KSP ksp, double squared) {
  ksp->rnorm = std::sqrt(std::abs(squared));
  PetscCall(KSPLogResidualHistory(ksp, ksp->rnorm));
  PetscCall(KSPMonitor(ksp, ksp->its, ksp->rnorm));
  PetscCall((*ksp->converged)(ksp, ksp->its, ksp->rnorm, &ksp->reason, ksp->cnvP));
  return 0;
}

/// Ends the iterations if the step just taken is predicted to meet the stop criterion, and reports the predicted norm.
/// The prediction uses the reduction of the norm by earlier steps. For the first step it assumes a reduction
/// to 0.6: that of steepest descent, (k - 1) / (k + 1), for the condition number k = 4 of M A (M: preconditioner, A:
/// matrix; docs/numerics/multigrid.md).
inline PetscErrorCode predict_end(KSP ksp, const CgScalars& scalars) {
  constexpr double first_step = 0.6;
  const double predicted = scalars.predicted_norm(ksp->its == 0 ? first_step : CgScalars::slow_step);
  PetscCall((*ksp->converged)(ksp, ksp->its + 1, predicted, &ksp->reason, ksp->cnvP));
  if (!ksp->reason) return 0;
  ++ksp->its;
  return report_norm(ksp, predicted * predicted);
}

/// Runs preconditioned conjugate gradients as a PETSc KSP, for vectors of any kind. `iteration` has three functions:
/// precondition(&r'z) sets z = M r; update_direction(beta, &p'A p) sets p = z + beta p; step(alpha) adds alpha p to x
/// and subtracts alpha A p from r. Sets the iterations and the reason of the end in `ksp`.
template <class Iteration>
PetscErrorCode iterate(KSP ksp, Iteration& iteration) {
  CgScalars scalars;
  double product = 0, curvature = 0;
  ksp->its = 0;
  PetscCall(iteration.precondition(&product));
  scalars.add(product);
  PetscCall(report_norm(ksp, product));
  while (!ksp->reason && ksp->its < ksp->max_it) {
    PetscCall(iteration.update_direction(scalars.beta, &curvature));
    if (!(curvature > 0)) {
      ksp->reason = KSP_DIVERGED_INDEFINITE_MAT;
      break;
    }
    PetscCall(iteration.step(product / curvature));
    PetscCall(PetscObjectStateIncrease(reinterpret_cast<PetscObject>(ksp->vec_sol)));
    PetscCall(predict_end(ksp, scalars));
    if (ksp->reason) break;
    PetscCall(iteration.precondition(&product));
    ++ksp->its;
    if (product < 0) {
      ksp->reason = KSP_DIVERGED_INDEFINITE_PC;
      break;
    }
    scalars.add(product);
    PetscCall(report_norm(ksp, product));
  }
  if (!ksp->reason) ksp->reason = KSP_DIVERGED_ITS;
  return 0;
}

}  // namespace lichtenberg::laplace
