#pragma once

// The iterations of CutCell, part of cutcell.hpp: conjugate gradients fused into one recording, or a method of PETSc.

#include "solvers/laplace/cutcell/device/cutcell.hpp"

namespace lichtenberg::laplace::device {

template <class Executor>
PetscErrorCode multiply(Mat matrix, ::Vec x, ::Vec y) {
  CutCell<Executor>* solver = nullptr;
  PetscCall(MatShellGetContext(matrix, &solver));
  return with_memory(x, y, [&](const double* from, double* to) { solver->multiply(from, to); });
}

template <class Executor>
PetscErrorCode precondition(PC pc, ::Vec r, ::Vec z) {
  CutCell<Executor>* solver = nullptr;
  PetscCall(PCShellGetContext(pc, &solver));
  return with_memory(r, z, [&](const double* from, double* to) { solver->precondition(from, to); });
}

template <class Executor>
void CutCell<Executor>::make_ksp(PetscInt n) {
  release_vectors();
  parallel::check_petsc(VecCreate(PETSC_COMM_SELF, &krylov_.x));
  parallel::check_petsc(VecSetSizes(krylov_.x, n, n));
  parallel::check_petsc(VecSetType(krylov_.x, PetscSide<Executor>::vector_type));
  parallel::check_petsc(VecDuplicate(krylov_.x, &krylov_.b));
  b_ = WriteAccess(krylov_.b);
  x_ = WriteAccess(krylov_.x);
  parallel::check_petsc(MatCreateShell(PETSC_COMM_SELF, n, n, n, n, this, &krylov_.matrix));
  parallel::check_petsc(MatShellSetVecType(krylov_.matrix, PetscSide<Executor>::vector_type));
  parallel::check_petsc(
      MatShellSetOperation(krylov_.matrix, MATOP_MULT, reinterpret_cast<void (*)(void)>(device::multiply<Executor>)));
  parallel::check_petsc(KSPCreate(PETSC_COMM_SELF, &krylov_.ksp));
  PC pc = nullptr;
  parallel::check_petsc(KSPGetPC(krylov_.ksp, &pc));
  parallel::check_petsc(PCSetType(pc, PCSHELL));
  parallel::check_petsc(PCShellSetApply(pc, device::precondition<Executor>));
  parallel::check_petsc(PCShellSetContext(pc, this));
  parallel::check_petsc(PCShellSetName(pc, "cut-cell multigrid on the device"));
  const char* method = PetscSide<Executor>::method;
  register_conjugate_gradients<CutCell>(method);
  krylov_.set_options(options_.tolerance, method);
  krylov_.require_shell();
  const auto is_type = [](auto object, const char* type) {
    PetscBool is = PETSC_FALSE;
    parallel::check_petsc(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(object), type, &is));
    return is == PETSC_TRUE;
  };
  is_fused_ = is_type(krylov_.ksp, method);
  if (is_fused_ && !is_type(pc, PCSHELL)) {
    parallel::check_petsc(KSPSetType(krylov_.ksp, KSPCG));
    is_fused_ = false;
  }
  if (is_type(krylov_.ksp, fused_cg))
    throw InputError(std::string("-field_ksp_type ") + fused_cg + " is the CPU's: leave the option out on a device");
  parallel::check_petsc(KSPSetOperators(krylov_.ksp, krylov_.matrix, krylov_.matrix));
  parallel::check_petsc(KSPSetUp(krylov_.ksp));
}

/// For the methods of PETSc.
template <class Executor>
void CutCell<Executor>::set_null_space(const LaplaceProblem& problem) {
  MatNullSpace space = nullptr;
  if (!problem.has_ground()) {
    ::Vec ones = nullptr;
    parallel::check_petsc(VecDuplicate(krylov_.x, &ones));
    {
      const WriteAccess value(ones);
      mark_unknowns(*run_, problem_->view(), finest().view(), static_cast<double*>(value));
    }
    parallel::check_petsc(VecNormalize(ones, nullptr));
    parallel::check_petsc(MatNullSpaceCreate(PETSC_COMM_SELF, PETSC_FALSE, 1, &ones, &space));
    parallel::check_petsc(VecDestroy(&ones));
  }
  krylov_.set_null_space(space);
}

/// An iteration: a V-cycle, and unless the residual is small enough by then, a step.
template <class Executor>
template <class Again>
void CutCell<Executor>::iterate_once(Again again) {
  const ProblemView& problem = problem_->view();
  const GridView& grid = finest().view();
  Iterations* iterations = iterations_.device;
  const Vectors& v = arrays_->view;
  multigrid_->cycle(v.z);
  if (!problem.grounded) level_out(*run_, problem, grid, v.z, potential_.device + problem.groups);
  judge(*run_, unknowns_, v.r, v.z, iterations);
  turn_direction(*run_, problem, grid, v.z, v.p, iterations);
  multiply(v.p, v.q);
  find_step(*run_, unknowns_, v.p, v.q, iterations, again);
  step_along(*run_, problem, grid, v.p, v.q, x_, v.r, iterations);
}

template <class Executor>
PetscErrorCode CutCell<Executor>::iterate(KSP ksp) {
  Iterations* iterations = iterations_.device;
  begin_iterations(*run_, krylov_.criterion.tolerance, static_cast<int>(ksp->max_it), iterations);
  if (multigrid_->on_device()) {
    run_->run(iterating_, [&] {
      better_guess();
      run_->repeat([this](auto again) { iterate_once(again); });
    });
  } else {
    better_guess();
    const auto host_asks = [] LICHTENBERG_HOST_DEVICE(bool) {};
    int go_on = 1;
    while (go_on) {
      iterate_once(host_asks);
      run_->to_host(&go_on, &iterations->go_on, sizeof go_on);
    }
  }
  finish();
  const Iterations& found = *iterations_.host;
  for (ksp->its = 0; ksp->its <= std::min(found.done, Iterations::kept - 1); ++ksp->its) {
    ksp->rnorm = found.norm[ksp->its];
    PetscCall(KSPLogResidualHistory(ksp, ksp->rnorm));
    PetscCall(KSPMonitor(ksp, ksp->its, ksp->rnorm));
  }
  ksp->its = found.done;
  krylov_.criterion.scale = found.scale;
  krylov_.criterion.last = found.scale > 0 ? ksp->rnorm / found.scale : 0.0;
  ksp->reason = is_settled_ ? static_cast<KSPConvergedReason>(found.reason) : KSP_CONVERGED_ITS;
  return 0;
}

/// By a method that the user has asked for.
template <class Executor>
void CutCell<Executor>::solve_by_petsc(LaplaceSolution& solution) {
  begin_iterations(*run_, 0, 0, iterations_.device);
  better_guess();
  report_->fetch();
  krylov_.criterion.energy_norm = iterations_.host->energy_norm;
  krylov_.criterion.rounding = iterations_.host->rounding;
  krylov_.solve(solution);
  finish();
}

}  // namespace lichtenberg::laplace::device
