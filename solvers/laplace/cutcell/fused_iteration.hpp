#pragma once

#include <petsc/private/kspimpl.h>

#include <algorithm>
#include <cmath>

#include "solvers/parallel/petsc.hpp"

namespace lichtenberg::laplace {

/// Registers solve(KSP) as a method that iterates by the natural norm, under `name`. Throws Failure.
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

/// Tells monitors, history and the stop criterion about the natural norm squared.
inline PetscErrorCode report_norm(KSP ksp, double squared) {
  ksp->rnorm = std::sqrt(std::abs(squared));
  PetscCall(KSPLogResidualHistory(ksp, ksp->rnorm));
  PetscCall(KSPMonitor(ksp, ksp->its, ksp->rnorm));
  PetscCall((*ksp->converged)(ksp, ksp->its, ksp->rnorm, &ksp->reason, ksp->cnvP));
  return 0;
}

/// Whether the step just taken was the last one: a V-cycle, five sixths of an iteration, would only find that it is
/// enough. A step is foreseen as one of the slowest so far, and as one that takes the norm to a half at best: of 1000
/// steps in scenes in motion none was slower, most went to a quarter. The first one, of which nothing is known yet, as
/// one of steepest descent in the spectrum of M A, .38 to 1.45 (README.md): to (1.45 - .38) / (1.45 + .38).
inline PetscErrorCode foresee_end(KSP ksp, double norm, double slowest_ratio) {
  constexpr double slow = 0.5, first = 0.6;
  const double foreseen = std::max(ksp->its == 0 ? first : slow, slowest_ratio) * norm;
  PetscCall((*ksp->converged)(ksp, ksp->its + 1, foreseen, &ksp->reason, ksp->cnvP));
  if (!ksp->reason) return 0;
  ++ksp->its;
  return report_norm(ksp, foreseen * foreseen);
}

/// Preconditioned conjugate gradients, on whatever the iteration keeps its vectors in. Its parts: precondition(&r'z)
/// sets z = M r, turn(beta, &p'A p) sets p = z + beta p, step(alpha) adds alpha p to x and takes alpha A p from r.
template <class Iteration>
PetscErrorCode iterate(KSP ksp, Iteration& iteration) {
  double product = 0, beta = 0, curvature = 0, largest_beta = 0;
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
    PetscCall(foresee_end(ksp, std::sqrt(product), std::sqrt(largest_beta)));
    if (ksp->reason) break;
    const double last = product;
    PetscCall(iteration.precondition(&product));
    ++ksp->its;
    if (product < 0) {
      ksp->reason = KSP_DIVERGED_INDEFINITE_PC;
      break;
    }
    beta = product / last;
    largest_beta = std::max(largest_beta, beta);
    PetscCall(report_norm(ksp, product));
  }
  if (!ksp->reason) ksp->reason = KSP_DIVERGED_ITS;
  return 0;
}

}  // namespace lichtenberg::laplace
