#pragma once

#include <petsc/private/kspimpl.h>

#include <cmath>

#include "solvers/laplace/cutcell/krylov.hpp"
#include "solvers/parallel/petsc.hpp"

namespace lichtenberg::laplace {

/// Registers solve(KSP) under `name` as a method that computes the natural norm. Throws Failure if PETSc reports an
/// error.
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

/// Reports the natural norm squared to monitors, the residual history and the stop criterion.
inline PetscErrorCode report_norm(KSP ksp, double squared) {
  ksp->rnorm = std::sqrt(std::abs(squared));
  PetscCall(KSPLogResidualHistory(ksp, ksp->rnorm));
  PetscCall(KSPMonitor(ksp, ksp->its, ksp->rnorm));
  PetscCall((*ksp->converged)(ksp, ksp->its, ksp->rnorm, &ksp->reason, ksp->cnvP));
  return 0;
}

/// Ends the iterations if the step just taken is predicted to be the last. Nothing is known of the first step: it is
/// taken for one of steepest descent in the spectrum of M A, .38 to 1.45 (docs/numerics/multigrid.md), which reduces
/// the norm to (1.45 - .38) / (1.45 + .38).
inline PetscErrorCode predict_end(KSP ksp, const CgScalars& scalars) {
  constexpr double first_step = 0.6;
  const double predicted = scalars.predicted_norm(ksp->its == 0 ? first_step : CgScalars::slow_step);
  PetscCall((*ksp->converged)(ksp, ksp->its + 1, predicted, &ksp->reason, ksp->cnvP));
  if (!ksp->reason) return 0;
  ++ksp->its;
  return report_norm(ksp, predicted * predicted);
}

/// Preconditioned conjugate gradients, for vectors of any kind. Parts of the iteration: precondition(&r'z) sets z = M
/// r, update_direction(beta, &p'A p) sets p = z + beta p, step(alpha) adds alpha p to x and subtracts alpha A p from r.
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
