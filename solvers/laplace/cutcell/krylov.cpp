#include "solvers/laplace/cutcell/krylov.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "solvers/error.hpp"
#include "solvers/laplace/cutcell/conjugate_gradients.hpp"
#include "solvers/parallel/petsc.hpp"

namespace lichtenberg::laplace {

namespace {

PetscErrorCode stop_test(KSP, PetscInt iteration, PetscReal norm, KSPConvergedReason* reason, void* context) {
  auto& criterion = *static_cast<StopCriterion*>(context);
  if (iteration == 0) criterion.scale = std::hypot(criterion.energy_norm, norm);
  criterion.last = criterion.scale > 0 ? norm / criterion.scale : 0.0;
  *reason = KSP_CONVERGED_ITERATING;
  if (!(std::isfinite(norm)))
    *reason = KSP_DIVERGED_NANORINF;
  else if (norm <= std::max(criterion.tolerance * criterion.scale, criterion.rounding))
    *reason = iteration == 0 ? KSP_CONVERGED_ATOL : KSP_CONVERGED_RTOL;
  return 0;
}

}  // namespace

void Krylov::release() {
  if (!parallel::petsc_started()) return;
  KSPDestroy(&ksp);
  MatDestroy(&matrix);
  VecDestroy(&x);
  VecDestroy(&b);
  MatNullSpaceDestroy(&null_space);
}

void Krylov::set_options(double tolerance, KSPType cg) {
  register_fused_cg();
  parallel::check_petsc(KSPSetOptionsPrefix(ksp, "field_"));
  parallel::check_petsc(KSPSetType(ksp, cg));
  parallel::check_petsc(KSPSetNormType(ksp, KSP_NORM_NATURAL));
  parallel::check_petsc(KSPSetTolerances(ksp, tolerance, PETSC_DEFAULT, PETSC_DEFAULT, 500));
  parallel::check_petsc(KSPSetInitialGuessNonzero(ksp, PETSC_TRUE));
  parallel::check_petsc(KSPSetConvergenceTest(ksp, stop_test, &criterion, nullptr));
  parallel::check_petsc(KSPSetFromOptions(ksp));
  PetscReal value = 0;
  PetscBool given = PETSC_FALSE;
  parallel::check_petsc(PetscOptionsGetReal(nullptr, "field_", "-ksp_rtol", &value, &given));
  if (given) rtol = value;
}

void Krylov::require_shell() {
  PC pc = nullptr;
  PCType type = nullptr;
  parallel::check_petsc(KSPGetPC(ksp, &pc));
  parallel::check_petsc(PCGetType(pc, &type));
  const std::string chosen = type;
  if (chosen == PCSHELL || chosen == PCNONE) return;
  release();
  throw InputError("-field_pc_type " + chosen +
                   " needs a matrix: set field.linear_solver = \"assembled\" in the scene, or leave the option out");
}

void Krylov::set_null_space(MatNullSpace space) {
  parallel::check_petsc(MatNullSpaceDestroy(&null_space));
  null_space = space;
  parallel::check_petsc(MatSetNullSpace(matrix, null_space));
}

void Krylov::solve(LaplaceSolution& solution) {
  if (rtol) criterion.tolerance = *rtol;
  parallel::check_petsc(KSPSolve(ksp, b, x));
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  PetscInt iterations = 0;
  parallel::check_petsc(KSPGetConvergedReason(ksp, &reason));
  parallel::check_petsc(KSPGetIterationNumber(ksp, &iterations));
  if (reason == KSP_DIVERGED_NANORINF)
    throw Failure("field solver: charges or potentials are too large for double precision, or lengths too small");
  if (reason < 0)
    throw Failure(std::string("field solver: no convergence after ") + std::to_string(iterations) + " iterations (" +
                  KSPConvergedReasons[reason] + ", relative error estimate " + std::to_string(criterion.last) +
                  "); a larger field.tolerance may be all that rounding allows");
  solution.iterations = static_cast<int>(iterations);
  solution.residual = criterion.last;
}

void check_petsc_options() {
  for (const std::string& option : parallel::unused_petsc_options()) {
    if (option.starts_with("-field_"))
      throw InputError("--petsc " + option +
                       ": the field solver has no such option (misspelt, or one of a method that it does not use)");
    if (option.starts_with("-ksp_") || option.starts_with("-pc_"))
      throw InputError("--petsc " + option + ": the field solver's options have a prefix, -field_" + option.substr(1));
  }
}

}  // namespace lichtenberg::laplace
