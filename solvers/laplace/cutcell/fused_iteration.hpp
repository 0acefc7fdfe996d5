#pragma once

#include <petsc/private/kspimpl.h>

#include <cmath>

namespace lichtenberg::laplace {

/// Tells monitors, history and the stop criterion about the natural norm squared.
inline PetscErrorCode report_norm(KSP ksp, double squared) {
  ksp->rnorm = std::sqrt(std::abs(squared));
  PetscCall(KSPLogResidualHistory(ksp, ksp->rnorm));
  PetscCall(KSPMonitor(ksp, ksp->its, ksp->rnorm));
  PetscCall((*ksp->converged)(ksp, ksp->its, ksp->rnorm, &ksp->reason, ksp->cnvP));
  return 0;
}

/// Preconditioned conjugate gradients, on whatever the iteration keeps its vectors in. Its parts: precondition(&r'z)
/// sets z = M r, turn(beta, &p'A p) sets p = z + beta p, step(alpha) adds alpha p to x and takes alpha A p from r.
template <class Iteration>
PetscErrorCode iterate(KSP ksp, Iteration& iteration) {
  double product = 0, beta = 0, curvature = 0;
  ksp->its = 0;
  PetscCall(iteration.precondition(&product));
  PetscCall(report_norm(ksp, product));
  while (!ksp->reason && ksp->its < ksp->max_it) {
    PetscCall(iteration.turn(beta, &curvature));
    if (!(curvature > 0)) {
      ksp->reason = KSP_DIVERGED_INDEFINITE_MAT;
      break;
    }
    PetscCall(iteration.step(product / curvature));
    PetscCall(PetscObjectStateIncrease(reinterpret_cast<PetscObject>(ksp->vec_sol)));
    const double last = product;
    PetscCall(iteration.precondition(&product));
    ++ksp->its;
    if (product < 0) {
      ksp->reason = KSP_DIVERGED_INDEFINITE_PC;
      break;
    }
    beta = product / last;
    PetscCall(report_norm(ksp, product));
  }
  if (!ksp->reason) ksp->reason = KSP_DIVERGED_ITS;
  return 0;
}

}  // namespace lichtenberg::laplace
