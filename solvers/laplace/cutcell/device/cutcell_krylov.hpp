#pragma once

// The iterations of CutCell, part of cutcell.hpp: conjugate gradients fused into one recording, or a method of PETSc.

#include "solvers/laplace/cutcell/device/cutcell.hpp"

namespace lichtenberg::laplace::device {

template <class Executor>
void CutCell<Executor>::make_ksp(PetscInt n) {
  release_vectors();
  parallel::check_petsc(VecCreate(PETSC_COMM_SELF, &krylov_.x));
  parallel::check_petsc(VecSetSizes(krylov_.x, n, n));
  parallel::check_petsc(VecSetType(krylov_.x, PetscSide<Executor>::vector_type));
  parallel::check_petsc(VecDuplicate(krylov_.x, &krylov_.b));
  b_ = WriteAccess(krylov_.b);
  x_ = WriteAccess(krylov_.x);
  const char* method = PetscSide<Executor>::method;
  const Shell shell = Shell::of(this, "cut-cell multigrid on the device", PetscSide<Executor>::vector_type);
  register_conjugate_gradients<CutCell>(method);
  krylov_.make_shell_matrix(shell, n);
  krylov_.make_shell_method(shell, options_.tolerance, method);
  is_fused_ = krylov_.is(method);
  if (krylov_.is(fused_cg))
    throw InputError(std::string("-field_ksp_type ") + fused_cg + " is the CPU's: leave the option out on a device");
  parallel::check_petsc(KSPSetOperators(krylov_.ksp, krylov_.matrix, krylov_.matrix));
  parallel::check_petsc(KSPSetUp(krylov_.ksp));
}

/// For the methods of PETSc.
template <class Executor>
void CutCell<Executor>::set_null_space(const LaplaceProblem& problem) {
  if (problem.has_ground()) return krylov_.set_null_space(nullptr);
  krylov_.set_constant_null_space(
      [this](double* value) { mark_unknowns(*run_, problem_->view(), finest().view(), value); });
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
