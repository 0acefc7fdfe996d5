#include "solvers/laplace/spheres/krylov.hpp"

#include <fmt/format.h>
#include <petscksp.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "solvers/error.hpp"
#include "solvers/parallel/petsc.hpp"
#include "solvers/stop.hpp"

namespace lichtenberg::laplace::spheres {
namespace {

using parallel::check_petsc;

/// Calls f(values of x, values of y); f overwrites y.
PetscErrorCode with_arrays(::Vec x, ::Vec y, const auto& f) {
  const PetscScalar* from = nullptr;
  PetscScalar* to = nullptr;
  PetscCall(VecGetArrayRead(x, &from));
  PetscCall(VecGetArrayWrite(y, &to));
  f(from, to);
  PetscCall(VecRestoreArrayRead(x, &from));
  PetscCall(VecRestoreArrayWrite(y, &to));
  return 0;
}

/// Product of the matrix, without projection, with the iterate of conjugate gradients. The method multiplies the matrix
/// by the direction of each step, so that the results of a solve need no further product. PETSc does not return the
/// lengths of the steps; the change of one component gives them. This is the direction's largest one: its rounding
/// error adds no more to the product than that of the iterate's largest component.
class IterateProduct {
 public:
  /// Starts from an iterate of zeros, which conjugate gradients change.
  explicit IterateProduct(const std::vector<double>& iterate)
      : iterate_(iterate), value_(iterate.size()), direction_product_(iterate.size()) {}
  /// Adds the last step and sets the direction of the next one. Returns the storage of the direction's product.
  double* next(const double* direction) {
    add_step();
    const Eigen::Map<const Eigen::VectorXd> all(direction, static_cast<Eigen::Index>(value_.size()));
    const double largest = all.lpNorm<Eigen::Infinity>();
    index_ = 0;
    while (index_ + 1 < all.size() && std::abs(all[index_]) != largest) ++index_;
    component_ = all[index_], before_ = iterate_[index_];
    return direction_product_.data();
  }
  /// Adds the last step and returns the product. Called once, at the end.
  const std::vector<double>& complete() {
    add_step();
    return value_;
  }

 private:
  void add_step() {
    const double step = component_ == 0 ? 0 : (iterate_[index_] - before_) / component_;
    for (std::size_t k = 0; k < value_.size(); ++k) value_[k] += step * direction_product_[k];
  }

  const std::vector<double>& iterate_;
  std::vector<double> value_, direction_product_;
  std::ptrdiff_t index_ = 0;
  double component_ = 0, before_ = 0;  ///< The direction's largest component, and that of the iterate before the step
};

/// Operator and preconditioner of conjugate gradients, for one right-hand side or for eight as one vector.
struct Shell {
  const System* system = nullptr;
  IterateProduct* product = nullptr;  ///< null: not computed
  PetscInt size = 0;
  PetscErrorCode (*multiply)(Mat, ::Vec, ::Vec) = nullptr;
  PetscErrorCode (*precondition)(PC, ::Vec, ::Vec) = nullptr;
};

PetscErrorCode multiply(Mat matrix, ::Vec x, ::Vec y) {
  const Shell* shell = nullptr;
  PetscCall(MatShellGetContext(matrix, &shell));
  const System* system = shell->system;
  return with_arrays(x, y, [&](const double* from, double* to) {
    system->apply(from, to);
    if (shell->product) std::copy_n(to, system->size(), shell->product->next(from));
    system->project(to);
  });
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

/// Calls change(column) for each of the eight columns.
void for_each_column(std::size_t size, Lanes* values, const auto& change) {
  std::vector<double> column(size);
  for (int lane = 0; lane < lanes; ++lane) {
    for (std::size_t k = 0; k < size; ++k) column[k] = values[k][lane];
    change(column.data());
    for (std::size_t k = 0; k < size; ++k) values[k][lane] = column[k];
  }
}

PetscErrorCode multiply_eight(Mat matrix, ::Vec x, ::Vec y) {
  const Shell* shell = nullptr;
  PetscCall(MatShellGetContext(matrix, &shell));
  const System* system = shell->system;
  return with_arrays(x, y, [&](const double* from, double* to) {
    std::vector<Lanes> columns(system->size()), product(columns.size());
    std::memcpy(columns.data(), from, columns.size() * sizeof(Lanes));
    system->apply(columns.data(), product.data());
    for_each_column(product.size(), product.data(), [&](double* column) { system->project(column); });
    std::memcpy(to, product.data(), product.size() * sizeof(Lanes));
  });
}

PetscErrorCode precondition_eight(PC pc, ::Vec x, ::Vec y) {
  const System* system = nullptr;
  PetscCall(PCShellGetContext(pc, &system));
  return with_arrays(x, y, [&](const double* from, double* to) {
    std::vector<Lanes> columns(system->size());
    std::memcpy(columns.data(), from, columns.size() * sizeof(Lanes));
    for_each_column(columns.size(), columns.data(), [&](double* column) { system->precondition(column); });
    std::memcpy(to, columns.data(), columns.size() * sizeof(Lanes));
  });
}

double length(const std::vector<double>& x) {
  double sum = 0;
  for (const double value : x) sum += value * value;
  return std::sqrt(sum);
}

/// Returns the rounding error of the right-hand side. Subtracting a potential common to a whole floating group, or to
/// all fixed groups of an insulated box, leaves rounding errors. They are all that remains for a neutral sphere in a
/// box of one potential, and for spheres at one potential without other conductors.
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

/// Computes the residual from the matrix's product with x, and returns its norm.
double residual_of(const System& system, const std::vector<double>& product, const std::vector<double>& given,
                   std::vector<double>& residual) {
  residual = product;
  system.project(residual.data());
  for (std::size_t k = 0; k < residual.size(); ++k) residual[k] = given[k] - residual[k];
  return length(residual);
}

struct Objects {
  KSP ksp = nullptr;
  Mat matrix = nullptr;
  ::Vec x = nullptr, b = nullptr, left = nullptr, step = nullptr;  ///< The last two serve methods other than CG
  ~Objects() {
    KSPDestroy(&ksp);
    MatDestroy(&matrix);
    VecDestroy(&x);
    VecDestroy(&b);
    VecDestroy(&left);
    VecDestroy(&step);
  }
};

/// Returns true if the options leave conjugate gradients that stop by the norm of the residual. For another method,
/// sets a norm that it supports.
bool stops_by_residual(KSP ksp) {
  KSPNormType norm = KSP_NORM_DEFAULT;
  PetscBool cg = PETSC_FALSE;
  check_petsc(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(ksp), KSPCG, &cg));
  if (KSPGetNormType(ksp, &norm) != 0) check_petsc(KSPSetNormType(ksp, KSP_NORM_DEFAULT));
  return cg == PETSC_TRUE && norm == KSP_NORM_UNPRECONDITIONED;
}

/// Ends the iteration after a stop request; otherwise PETSc's own test.
PetscErrorCode stop_test(KSP ksp, PetscInt iteration, PetscReal norm, KSPConvergedReason* reason, void* context) {
  if (!StopRequestScope::requested()) return KSPConvergedDefault(ksp, iteration, norm, reason, context);
  *reason = KSP_DIVERGED_BREAKDOWN;
  return 0;
}

struct SolveOutcome {
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  PetscInt iterations = 0;
  PetscReal residual = 0;  ///< Norm of the residual
};

SolveOutcome outcome_of(KSP ksp) {
  SolveOutcome outcome;
  check_petsc(KSPGetIterationNumber(ksp, &outcome.iterations));
  check_petsc(KSPGetResidualNorm(ksp, &outcome.residual));
  check_petsc(KSPGetConvergedReason(ksp, &outcome.reason));
  return outcome;
}

/// Solves by a user-chosen method that stops by a norm of its own. Repeats it for the remaining residual, until its
/// norm is at most `goal` or a repetition no longer halves it.
SolveOutcome refine(Objects& petsc, double goal) {
  constexpr double margin = 0.3, progress = 0.5;
  check_petsc(VecDuplicate(petsc.b, &petsc.left));
  check_petsc(VecDuplicate(petsc.b, &petsc.step));
  check_petsc(VecCopy(petsc.b, petsc.left));
  check_petsc(VecSet(petsc.x, 0));
  SolveOutcome outcome;
  check_petsc(VecNorm(petsc.left, NORM_2, &outcome.residual));
  while (outcome.residual > goal) {
    check_petsc(
        KSPSetTolerances(petsc.ksp, margin * goal / outcome.residual, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
    check_petsc(KSPSolve(petsc.ksp, petsc.left, petsc.step));
    stop_if_requested();
    check_petsc(VecAXPY(petsc.x, 1, petsc.step));
    check_petsc(MatMult(petsc.matrix, petsc.x, petsc.left));
    check_petsc(VecAYPX(petsc.left, -1, petsc.b));
    const SolveOutcome start = outcome_of(petsc.ksp);
    const double before = outcome.residual;
    check_petsc(VecNorm(petsc.left, NORM_2, &outcome.residual));
    outcome.iterations += start.iterations;
    if (outcome.residual > goal && !(outcome.residual < progress * before && start.reason != KSP_DIVERGED_ITS)) {
      outcome.reason = start.reason < 0 ? start.reason : KSP_DIVERGED_ITS;
      return outcome;
    }
  }
  outcome.reason = KSP_CONVERGED_ATOL;
  return outcome;
}

/// Returns the smallest eigenvalue of the preconditioned matrix that conjugate gradients found; 1 for other methods.
double smallest_eigenvalue(KSP ksp) {
  PetscBool known = PETSC_FALSE;
  check_petsc(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(ksp), KSPCG, &known));
  PetscReal largest = 1, smallest = 1;
  if (known) check_petsc(KSPComputeExtremeSingularValues(ksp, &largest, &smallest));
  return smallest > 0 ? smallest : 1;
}

/// Solves from x = 0 until the residual is at most `goal`; the result's residual is relative to `scale`.
KrylovResult conjugate_gradients(const Shell& shell, double* right_hand_side, double* x, double goal, double scale) {
  Objects petsc;
  check_petsc(VecCreateSeqWithArray(PETSC_COMM_SELF, 1, shell.size, right_hand_side, &petsc.b));
  check_petsc(VecCreateSeqWithArray(PETSC_COMM_SELF, 1, shell.size, x, &petsc.x));
  check_petsc(MatCreateShell(PETSC_COMM_SELF, shell.size, shell.size, shell.size, shell.size,
                             const_cast<Shell*>(&shell), &petsc.matrix));
  for (const MatOperation kind : {MATOP_MULT, MATOP_MULT_TRANSPOSE})
    check_petsc(MatShellSetOperation(petsc.matrix, kind, reinterpret_cast<void (*)()>(shell.multiply)));
  check_petsc(KSPCreate(PETSC_COMM_SELF, &petsc.ksp));
  check_petsc(KSPSetOptionsPrefix(petsc.ksp, "spheres_"));
  check_petsc(KSPSetType(petsc.ksp, KSPCG));
  PC pc = nullptr;
  check_petsc(KSPGetPC(petsc.ksp, &pc));
  check_petsc(PCSetType(pc, PCSHELL));
  check_petsc(PCShellSetContext(pc, const_cast<System*>(shell.system)));
  check_petsc(PCShellSetApply(pc, shell.precondition));
  check_petsc(PCShellSetApplyTranspose(pc, shell.precondition));  // Symmetric, like the matrix
  check_petsc(KSPSetNormType(petsc.ksp, KSP_NORM_UNPRECONDITIONED));
  check_petsc(KSPSetOperators(petsc.ksp, petsc.matrix, petsc.matrix));
  check_petsc(KSPSetTolerances(petsc.ksp, 0, goal, PETSC_DEFAULT, 2000));
  void* test_context = nullptr;
  check_petsc(KSPConvergedDefaultCreate(&test_context));
  check_petsc(KSPSetConvergenceTest(petsc.ksp, stop_test, test_context, KSPConvergedDefaultDestroy));
  check_petsc(KSPSetComputeSingularValues(petsc.ksp, PETSC_TRUE));
  check_petsc(KSPSetFromOptions(petsc.ksp));
  SolveOutcome outcome;
  if (stops_by_residual(petsc.ksp)) {
    check_petsc(KSPSolve(petsc.ksp, petsc.b, petsc.x));
    stop_if_requested();
    outcome = outcome_of(petsc.ksp);
  } else {
    outcome = refine(petsc, goal);
  }
  if (outcome.reason < 0)
    throw Failure(fmt::format("the field of spheres: no convergence after {} iterations ({}, relative residual {:.3g})",
                              outcome.iterations, KSPConvergedReasons[outcome.reason], outcome.residual / scale));
  return {static_cast<int>(outcome.iterations), outcome.residual / scale, smallest_eigenvalue(petsc.ksp)};
}

/// Solutions for eight groups, each at 1 V in its own column, and the remaining residuals.
struct EightColumns {
  std::vector<Lanes> x, residual;
};

/// Solves for the groups from `first` on; columns beyond the last group are 0. Each right-hand side is normalized, so
/// that all columns reach the tolerance.
EightColumns solve_eight(const System& system, int first, double tolerance) {
  const auto n = static_cast<std::size_t>(system.size());
  const int count = std::min(lanes, static_cast<int>(system.problem().groups.size()) - first);
  std::vector<Lanes> given(n);
  EightColumns eight{.x = std::vector<Lanes>(n), .residual = std::vector<Lanes>(n)};
  Lanes lengths{};
  double squares = 0;
  for (int lane = 0; lane < count; ++lane) {
    std::vector<double> column = system.unit_potential(first + lane);
    const double whole = length(column);
    system.project(column.data());
    const double left = length(column);
    if (left <= 100 * std::numeric_limits<double>::epsilon() * whole) continue;  // Insulated box as one group
    lengths[lane] = left;
    squares += 1;
    for (std::size_t k = 0; k < n; ++k) given[k][lane] = column[k] / left;
  }
  if (squares == 0) return eight;
  std::vector<double> from(n * lanes), to(n * lanes);
  std::memcpy(from.data(), given.data(), n * sizeof(Lanes));
  // Bound on the residual of a single column, as if it contained the whole residual.
  const double goal = std::max(tolerance, 4 * std::numeric_limits<double>::epsilon() * std::sqrt(squares));
  conjugate_gradients({&system, nullptr, static_cast<PetscInt>(n * lanes), multiply_eight, precondition_eight},
                      from.data(), to.data(), goal, 1);
  std::memcpy(eight.x.data(), to.data(), n * sizeof(Lanes));
  system.apply(eight.x.data(), eight.residual.data());
  for_each_column(n, eight.residual.data(), [&](double* column) { system.project(column); });
  for (std::size_t k = 0; k < n; ++k) {
    eight.residual[k] = lengths * (given[k] - eight.residual[k]);
    eight.x[k] *= lengths;
  }
  return eight;
}

/// Returns the tolerance of the iteration of unit_charges, whose errors are squares of residuals over the smallest
/// eigenvalue, which is taken as 0.01.
double second_order_tolerance(double tolerance) { return std::max(tolerance, 0.1 * std::sqrt(tolerance)); }

}  // namespace

KrylovResult solve_krylov(const System& system, double tolerance, std::vector<double>& x) {
  parallel::start_petsc();
  const PetscInt n = system.size();
  std::vector<double> product(n), residual, correction(n);
  const std::vector<double> cold = system.start();
  std::vector<double> given = system.right_hand_side();
  system.project(given.data());
  const double scale = std::hypot(length(given), length(cold));
  system.apply(x.data(), product.data());
  double first = residual_of(system, product, given, residual);
  if (first > scale) {  // The initial guess is of another size, for example after charges have flowed to ground
    x = cold;
    system.apply(x.data(), product.data());
    first = residual_of(system, product, given, residual);
  }
  const double goal = std::max(tolerance * scale, rounding(system));
  if (first <= goal) return {0, scale > 0 ? first / scale : 0, 1, std::move(product)};
  IterateProduct followed(correction);
  KrylovResult result = conjugate_gradients({&system, &followed, n, multiply, precondition}, residual.data(),
                                            correction.data(), goal, scale);
  const std::vector<double>& added = followed.complete();
  for (PetscInt k = 0; k < n; ++k) x[k] += correction[k], product[k] += added[k];
  // PETSc's options can select a method whose products are not of directions of steps.
  if (!(residual_of(system, product, given, residual) <= 2 * goal)) system.apply(x.data(), product.data());
  result.product = std::move(product);
  return result;
}

std::vector<double> unit_charges(const System& system, double tolerance) {
  parallel::start_petsc();
  const int groups = static_cast<int>(system.problem().groups.size());
  const Eigen::Index n = system.size();
  constexpr double most_numbers = 2e7;  // About 300 MB
  const bool second_order = static_cast<double>(n) * groups <= most_numbers;
  Eigen::MatrixXd x(n, second_order ? groups : 1), residual(n, x.cols());
  Eigen::MatrixXd charge(groups, groups);
  for (int first = 0; first < groups; first += lanes) {
    const EightColumns eight = solve_eight(system, first, second_order ? second_order_tolerance(tolerance) : tolerance);
    for (int lane = 0; lane < std::min(lanes, groups - first); ++lane) {
      const Eigen::Index column = second_order ? first + lane : 0;
      for (Eigen::Index k = 0; k < n; ++k) {
        x(k, column) = eight.x[k][lane];
        residual(k, column) = eight.residual[k][lane];
      }
      const std::vector<double> found = system.group_charges(x.col(column).data());
      charge.col(first + lane) = Eigen::Map<const Eigen::VectorXd>(found.data(), groups);
    }
  }
  if (second_order) charge += x.transpose() * residual;
  std::vector<double> result;
  for (int i = 0; i < groups; ++i)
    for (int j = 0; j < groups; ++j) result.push_back(charge(i, j));
  return result;
}

}  // namespace lichtenberg::laplace::spheres
