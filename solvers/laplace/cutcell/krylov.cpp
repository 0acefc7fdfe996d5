#include "solvers/laplace/cutcell/krylov.hpp"

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "solvers/error.hpp"
#include "solvers/laplace/cutcell/conjugate_gradients.hpp"
#include "solvers/parallel/petsc.hpp"
#include "solvers/stop.hpp"

namespace lichtenberg::laplace {

namespace {

int most_iterations(KSP ksp) {
  PetscInt most = 0;
  KSPGetTolerances(ksp, nullptr, nullptr, nullptr, &most);
  return static_cast<int>(most);
}

PetscErrorCode stop_test(KSP ksp, PetscInt iteration, PetscReal norm, KSPConvergedReason* reason, void* context) {
  auto& krylov = *static_cast<Krylov*>(context);
  StopCriterion& criterion = krylov.criterion;
  if (StopRequestScope::requested()) {  // Krylov::solve throws Stopped
    *reason = KSP_DIVERGED_BREAKDOWN;
    return 0;
  }
  if (!krylov.has_natural_norm) {
    try {
      norm = krylov.natural_norm_of_iterate();
    } catch (const Failure&) {  // no exception may pass through PETSc's C code
      *reason = KSP_DIVERGED_BREAKDOWN;
      return 0;
    }
  } else if (iteration == 0) {
    criterion.begin(norm);
  }
  criterion.record(norm);
  *reason = KSP_CONVERGED_ITERATING;
  if (!(std::isfinite(norm)))
    *reason = KSP_DIVERGED_NANORINF;
  else if (criterion.is_met_by(norm))
    *reason = iteration == 0 ? KSP_CONVERGED_ATOL : KSP_CONVERGED_RTOL;
  else if (!krylov.has_natural_norm && iteration + krylov.iterations_before >= most_iterations(ksp))
    *reason = KSP_DIVERGED_ITS;
  else if (krylov.may_stall && krylov.stall.is_stalled(norm))
    *reason = KSP_DIVERGED_BREAKDOWN;  // Krylov::solve starts the method again
  return 0;
}

bool is_given(const char* option) {
  PetscBool given = PETSC_FALSE;
  parallel::check_petsc(PetscOptionsHasName(nullptr, "field_", option, &given));
  return given == PETSC_TRUE;
}

template <class Object>
bool is_type(Object object, const char* type) {
  PetscBool is = PETSC_FALSE;
  parallel::check_petsc(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(object), type, &is));
  return is == PETSC_TRUE;
}

/// Returns true if the method is direct: it uses no guess and has no norm to iterate by.
bool is_direct(KSP ksp) { return is_type(ksp, KSPPREONLY); }

PC preconditioner(KSP ksp) {
  PC pc = nullptr;
  parallel::check_petsc(KSPGetPC(ksp, &pc));
  return pc;
}

/// Returns true if the preconditioner is the geometric multigrid.
bool has_shell(KSP ksp) { return is_type(preconditioner(ksp), PCSHELL); }

/// Allows factorizations with a last pivot that is rounding or 0, because the matrix is singular without ground.
void allow_singular_factors(KSP ksp) {
  PC pc = preconditioner(ksp);
  PetscBool factors = PETSC_FALSE;
  parallel::check_petsc(PetscObjectTypeCompareAny(reinterpret_cast<PetscObject>(pc), &factors, PCLU, PCCHOLESKY, ""));
  if (factors && !is_given("-pc_factor_shift_type")) parallel::check_petsc(PCFactorSetShiftType(pc, MAT_SHIFT_NONZERO));
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

bool Krylov::is(KSPType type) const { return is_type(ksp, type); }

void Krylov::make_shell_matrix(const Shell& shell, PetscInt n) {
  parallel::check_petsc(MatCreateShell(PETSC_COMM_WORLD, n, n, PETSC_DETERMINE, PETSC_DETERMINE, shell.work, &matrix));
  parallel::check_petsc(MatShellSetVecType(matrix, shell.vector_type));
  for (const MatOperation operation : {MATOP_MULT, MATOP_MULT_TRANSPOSE})  // it is symmetric
    parallel::check_petsc(MatShellSetOperation(matrix, operation, reinterpret_cast<void (*)()>(shell.multiply)));
}

void Krylov::make_shell_method(const Shell& shell, double tolerance, KSPType cg) {
  parallel::check_petsc(KSPCreate(PETSC_COMM_WORLD, &ksp));
  PC pc = preconditioner(ksp);
  parallel::check_petsc(PCSetType(pc, PCSHELL));
  parallel::check_petsc(PCShellSetApply(pc, shell.precondition));
  parallel::check_petsc(PCShellSetApplyTranspose(pc, shell.precondition));
  parallel::check_petsc(PCShellSetContext(pc, shell.work));
  parallel::check_petsc(PCShellSetName(pc, shell.name));
  set_options(tolerance, cg);
  require_shell();
  require_own_method(cg);
  if (is(cg) && !has_shell(ksp)) parallel::check_petsc(KSPSetType(ksp, KSPCG));
}

void Krylov::set_options(double tolerance, KSPType cg) {
  register_fused_cg();
  parallel::check_petsc(KSPSetOptionsPrefix(ksp, "field_"));
  parallel::check_petsc(KSPSetType(ksp, cg));
  parallel::check_petsc(KSPSetTolerances(ksp, tolerance, PETSC_DEFAULT, PETSC_DEFAULT, 500));
  parallel::check_petsc(KSPSetInitialGuessNonzero(ksp, PETSC_TRUE));
  parallel::check_petsc(KSPSetConvergenceTest(ksp, stop_test, this, nullptr));
  parallel::check_petsc(KSPSetFromOptions(ksp));
  if (is_direct(ksp)) parallel::check_petsc(KSPSetInitialGuessNonzero(ksp, PETSC_FALSE));
  choose_norm();
  allow_singular_factors(ksp);
  PetscReal value = 0;
  PetscBool given = PETSC_FALSE;
  parallel::check_petsc(PetscOptionsGetReal(nullptr, "field_", "-ksp_rtol", &value, &given));
  if (given) rtol = value;
}

/// Chooses the natural norm where the method supports it and options name no other. Else the method keeps its own norm
/// and the stop criterion computes the natural one.
void Krylov::choose_norm() {
  KSPNormType norm = KSP_NORM_DEFAULT;
  if (is_given("-ksp_norm_type")) {
    parallel::check_petsc(KSPGetNormType(ksp, &norm));
  } else {
    parallel::check_petsc(KSPSetNormType(ksp, KSP_NORM_NATURAL));
    if (KSPGetNormType(ksp, &norm) != 0) {  // PETSc has no other query for support
      norm = KSP_NORM_DEFAULT;
      parallel::check_petsc(KSPSetNormType(ksp, norm));
    }
  }
  // PETSc accepts any norm for a direct method and computes none. -field_ksp_norm_type none removes the criterion.
  has_natural_norm = norm == KSP_NORM_NATURAL && !is_direct(ksp);
  if (norm == KSP_NORM_NONE) parallel::check_petsc(KSPSetConvergenceTest(ksp, stop_test, this, nullptr));
}

namespace {

/// Computes sqrt(r' M r) of the residual r of the method's iterate (`uses_iterate`) or of x (M: preconditioner).
double natural_norm(const Krylov& krylov, bool uses_iterate) {
  ::Vec work = nullptr, residual = nullptr, preconditioned = nullptr;
  parallel::check_petsc(VecDuplicate(krylov.b, &work));
  parallel::check_petsc(VecDuplicate(krylov.b, &residual));
  parallel::check_petsc(VecDuplicate(krylov.b, &preconditioned));
  if (uses_iterate) {
    ::Vec built = nullptr;
    parallel::check_petsc(KSPBuildResidual(krylov.ksp, work, residual, &built));
  } else {
    parallel::check_petsc(MatMult(krylov.matrix, krylov.x, residual));
    parallel::check_petsc(VecAYPX(residual, -1, krylov.b));
  }
  parallel::check_petsc(PCApply(preconditioner(krylov.ksp), residual, preconditioned));
  // Removes the constant that rounding leaves in the residual; a preconditioner of a singular matrix may magnify it.
  if (krylov.null_space) parallel::check_petsc(MatNullSpaceRemove(krylov.null_space, preconditioned));
  PetscScalar product = 0;
  parallel::check_petsc(VecDot(residual, preconditioned, &product));
  for (::Vec* vector : {&work, &residual, &preconditioned}) parallel::check_petsc(VecDestroy(vector));
  return std::sqrt(std::abs(product));
}

}  // namespace

double Krylov::natural_norm_of_iterate() const { return natural_norm(*this, true); }

void Krylov::require_shell() {
  PCType type = nullptr;
  parallel::check_petsc(PCGetType(preconditioner(ksp), &type));
  const std::string chosen = type;
  if (chosen == PCSHELL || chosen == PCNONE) return;
  release();
  throw InputError("-field_pc_type " + chosen +
                   " needs a matrix: set field.linear_solver = \"assembled\" in the scene, or leave the option out");
}

/// Throws InputError if several processes use another method than `cg`: PETSc's methods would count ghost rows twice.
void Krylov::require_own_method(KSPType cg) {
  if (parallel::process_count() == 1 || (is(cg) && has_shell(ksp))) return;
  release();
  throw InputError(
      "with field.linear_solver = \"multigrid\" several processes use the method cutcell and its preconditioner only: "
      "leave -field_ksp_type and -field_pc_type out, or set field.linear_solver = \"assembled\"");
}

void Krylov::set_null_space(MatNullSpace space) {
  parallel::check_petsc(MatNullSpaceDestroy(&null_space));
  null_space = space;
  parallel::check_petsc(MatSetNullSpace(matrix, null_space));
}

/// Solves with a method that does not compute the natural norm. Starts it again while each start halves the norm.
KSPConvergedReason Krylov::solve_with_restarts() {
  constexpr double progress = 0.5;  // of the norm, without which another start is of no use
  parallel::check_petsc(KSPSetUp(ksp));
  may_stall = has_shell(ksp);
  double norm = natural_norm(*this, false);
  criterion.begin(norm);
  while (true) {
    const double before = norm;
    PetscInt iterations = 0;
    KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
    stall.start(norm);
    parallel::check_petsc(KSPSolve(ksp, b, x));
    stop_if_requested();
    parallel::check_petsc(KSPGetConvergedReason(ksp, &reason));
    parallel::check_petsc(KSPGetIterationNumber(ksp, &iterations));
    iterations_before += static_cast<int>(iterations);
    if (reason == KSP_DIVERGED_NANORINF) return reason;
    norm = natural_norm(*this, false);  // a method without a norm has not been tested
    criterion.record(norm);
    if (criterion.is_met_by(norm)) return KSP_CONVERGED_RTOL;
    if (is_direct(ksp) || reason == KSP_DIVERGED_ITS || !(norm < progress * before))
      return reason < 0 ? reason : KSP_DIVERGED_ITS;
  }
}

void Krylov::solve(LaplaceSolution& solution) {
  if (rtol) criterion.tolerance = *rtol;
  iterations_before = 0;
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  PetscInt iterations = 0;
  if (has_natural_norm) {
    parallel::check_petsc(KSPSolve(ksp, b, x));
    stop_if_requested();
    parallel::check_petsc(KSPGetConvergedReason(ksp, &reason));
    parallel::check_petsc(KSPGetIterationNumber(ksp, &iterations));
  } else {
    reason = solve_with_restarts();
    iterations = iterations_before;
  }
  if (reason == KSP_DIVERGED_NANORINF)
    throw Failure("field solver: charges or potentials are too large for double precision, or lengths too small");
  if (reason < 0)
    throw Failure(
        fmt::format("field solver: no convergence after {} iterations ({}, relative error estimate {:.2g}); a larger "
                    "field.tolerance may be all that rounding allows",
                    iterations, KSPConvergedReasons[reason], criterion.last));
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
