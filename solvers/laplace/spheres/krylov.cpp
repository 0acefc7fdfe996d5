#include "solvers/laplace/spheres/krylov.hpp"

#include <fmt/format.h>
#include <petscksp.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "solvers/error.hpp"
#include "solvers/parallel/petsc.hpp"

namespace lichtenberg::laplace::spheres {
namespace {

using parallel::check_petsc;

PetscErrorCode multiply(Mat matrix, ::Vec x, ::Vec y) {
  const System* system = nullptr;
  PetscCall(MatShellGetContext(matrix, &system));
  const PetscScalar* from = nullptr;
  PetscScalar* to = nullptr;
  PetscCall(VecGetArrayRead(x, &from));
  PetscCall(VecGetArrayWrite(y, &to));
  system->apply(from, to);
  system->project(to);
  PetscCall(VecRestoreArrayRead(x, &from));
  PetscCall(VecRestoreArrayWrite(y, &to));
  return 0;
}

PetscErrorCode precondition(PC pc, ::Vec x, ::Vec y) {
  const System* system = nullptr;
  PetscCall(PCShellGetContext(pc, &system));
  PetscCall(VecCopy(x, y));
  PetscScalar* values = nullptr;
  PetscCall(VecGetArray(y, &values));
  system->precondition(values);
  PetscCall(VecRestoreArray(y, &values));
  return 0;
}

double length(const std::vector<double>& x) {
  double sum = 0;
  for (const double value : x) sum += value * value;
  return std::sqrt(sum);
}

/// Of the right hand side, from which a potential that all of a floating group, or all fixed groups of an insulated
/// box, are given is taken off: some roundings of it stay. Of a neutral sphere in a box of one potential, and of
/// spheres at one potential that nothing else surrounds, nothing else does.
double rounding(const System& system) {
  const SphereProblem& problem = system.problem();
  double sum = 0;
  for (std::size_t i = 0; i < problem.spheres.size(); ++i) {
    const Group& group = problem.groups[problem.spheres[i].group];
    const double wall = system.wall().at(system.sites()[i].centre), fixed = group.floating ? 0 : group.potential;
    sum += system.sites()[i].radius * (wall * wall + fixed * fixed);
  }
  return 4 * std::numeric_limits<double>::epsilon() * std::sqrt(sum);
}

/// Its length.
double residual_of(const System& system, const std::vector<double>& x, const std::vector<double>& given,
                   std::vector<double>& residual) {
  residual.resize(x.size());
  system.apply(x.data(), residual.data());
  system.project(residual.data());
  for (std::size_t k = 0; k < x.size(); ++k) residual[k] = given[k] - residual[k];
  return length(residual);
}

struct Objects {
  KSP ksp = nullptr;
  Mat matrix = nullptr;
  ::Vec x = nullptr, b = nullptr;
  ~Objects() {
    KSPDestroy(&ksp);
    MatDestroy(&matrix);
    VecDestroy(&x);
    VecDestroy(&b);
  }
};

}  // namespace

KrylovResult solve_krylov(const System& system, double tolerance, std::vector<double>& x) {
  parallel::start_petsc();
  const PetscInt n = system.size();
  std::vector<double> residual, correction(n);
  const std::vector<double> cold = system.start();
  std::vector<double> given = system.right_hand_side();
  system.project(given.data());
  const double scale = std::hypot(length(given), length(cold));
  double first = residual_of(system, x, given, residual);
  if (first > scale) {  // what is known is of another size: of charges that have gone to ground, say
    x = cold;
    first = residual_of(system, x, given, residual);
  }
  const double goal = std::max(tolerance * scale, rounding(system));
  if (first <= goal) return {0, scale > 0 ? first / scale : 0};

  Objects petsc;
  check_petsc(VecCreateSeqWithArray(PETSC_COMM_SELF, 1, n, residual.data(), &petsc.b));
  check_petsc(VecCreateSeqWithArray(PETSC_COMM_SELF, 1, n, correction.data(), &petsc.x));
  check_petsc(MatCreateShell(PETSC_COMM_SELF, n, n, n, n, const_cast<System*>(&system), &petsc.matrix));
  check_petsc(MatShellSetOperation(petsc.matrix, MATOP_MULT, reinterpret_cast<void (*)()>(multiply)));
  check_petsc(KSPCreate(PETSC_COMM_SELF, &petsc.ksp));
  check_petsc(KSPSetOptionsPrefix(petsc.ksp, "spheres_"));
  check_petsc(KSPSetType(petsc.ksp, KSPCG));
  PC pc = nullptr;
  check_petsc(KSPGetPC(petsc.ksp, &pc));
  check_petsc(PCSetType(pc, PCSHELL));
  check_petsc(PCShellSetContext(pc, const_cast<System*>(&system)));
  check_petsc(PCShellSetApply(pc, precondition));
  check_petsc(KSPSetNormType(petsc.ksp, KSP_NORM_UNPRECONDITIONED));
  check_petsc(KSPSetOperators(petsc.ksp, petsc.matrix, petsc.matrix));
  check_petsc(KSPSetTolerances(petsc.ksp, 0, goal, PETSC_DEFAULT, 2000));
  check_petsc(KSPSetFromOptions(petsc.ksp));
  check_petsc(KSPSolve(petsc.ksp, petsc.b, petsc.x));
  PetscInt iterations = 0;
  PetscReal last = 0;
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  check_petsc(KSPGetIterationNumber(petsc.ksp, &iterations));
  check_petsc(KSPGetResidualNorm(petsc.ksp, &last));
  check_petsc(KSPGetConvergedReason(petsc.ksp, &reason));
  if (reason < 0)
    throw Failure(fmt::format("the field of spheres: no convergence after {} iterations ({}, relative residual {:.3g})",
                              iterations, KSPConvergedReasons[reason], last / scale));
  for (PetscInt k = 0; k < n; ++k) x[k] += correction[k];
  return {static_cast<int>(iterations), last / scale};
}

}  // namespace lichtenberg::laplace::spheres
