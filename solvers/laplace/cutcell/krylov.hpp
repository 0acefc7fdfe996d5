#pragma once

#include <petscksp.h>

#include <cmath>
#include <optional>

#include "solvers/geometry/host_device.hpp"
#include "solvers/laplace/cutcell/shell.hpp"
#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

/// Stop criterion of conjugate gradients. The natural norm sqrt(r' M r) of the residual r estimates the energy norm of
/// the error (M: preconditioner). It must fall to `tolerance` times the estimated energy norm of the solution, or to
/// the level of rounding. The plain residual norm gives no such bound: a short link, from a cell centre close to a
/// conductor, makes it very large.
struct StopCriterion {
  double tolerance = 0;
  /// Energy norm of the initial guess.
  double energy_norm = 0;
  /// Estimate of the solution's energy norm.
  double scale = 0;
  /// Last natural norm, divided by `scale`.
  double last = 0;
  /// Natural norm of a residual that consists of rounding errors only. It matters if all potentials are equal, so that
  /// the energy is zero.
  double rounding = 0;

  /// Sets `scale` to sqrt(energy_norm^2 + norm^2). `norm`: natural norm of the first residual.
  LICHTENBERG_HOST_DEVICE void begin(double norm) { scale = std::hypot(energy_norm, norm); }
  /// Stores the natural norm, divided by `scale`, in `last` (0 if `scale` is 0).
  void record(double norm) { last = scale > 0 ? norm / scale : 0.0; }
  /// Returns true if the natural norm is at most `tolerance` * `scale`, or at most `rounding`.
  LICHTENBERG_HOST_DEVICE bool is_met_by(double norm) const {
    const double relative = tolerance * scale;
    return norm <= (relative < rounding ? rounding : relative);
  }
};

/// Scalars of the conjugate gradient iteration, for the CPU and a device. r is the residual and z = M r the
/// preconditioned residual (M: preconditioner).
struct CgScalars {
  /// Scalar product r'z of the last residual.
  double product = 0;
  /// Ratio of the last two products r'z, and the largest such ratio so far.
  double beta = 0, largest = 0;
  /// Number of products so far.
  int residuals = 0;

  /// Stores the next scalar product r'z of the residual r and the preconditioned residual z. Updates beta, its ratio to
  /// the previous product, and the largest beta.
  LICHTENBERG_HOST_DEVICE void add(double next) {
    beta = residuals > 0 ? next / product : 0.0;
    largest = beta > largest ? beta : largest;
    product = next;
    ++residuals;
  }
  /// Predicts the natural norm after the CG step that starts from the last residual. The step is assumed to reduce the
  /// norm by the factor `slow`, or as little as the slowest step so far. If the prediction meets the stop criterion,
  /// the next V-cycle would only confirm it; a V-cycle costs 5/6 of an iteration.
  LICHTENBERG_HOST_DEVICE double predicted_norm(double slow) const {
    const double slowest = std::sqrt(largest);
    return (slowest > slow ? slowest : slow) * std::sqrt(std::abs(product));
  }
  /// Assumed reduction of the norm by a slow step.
  static constexpr double slow_step = 0.5;
};

/// Detection of stagnation: ten iterations in which no norm fell below 0.9 of the best. The multigrid works in single
/// precision and is not exactly a linear map. Short recurrences that rely on linearity (MINRES, BiCGStab) can stagnate
/// with it.
struct StallTest {
  double best = 0;
  int iterations = 0;  ///< iterations since `best`

  /// Starts the stagnation test with the first residual norm.
  void start(double norm) { best = norm, iterations = 0; }
  /// Adds the residual norm of an iteration. Returns true if the method stagnates: ten iterations without a norm below
  /// 0.9 of the best.
  bool is_stalled(double norm) {
    constexpr double progress = 0.9;
    constexpr int most_slow_iterations = 10;
    if (norm < progress * best)
      start(norm);
    else
      ++iterations;
    return iterations >= most_slow_iterations;
  }
};

/// A PETSc Krylov method (KSP) with its matrix, vectors and null space, and the stop criterion in the natural norm.
struct Krylov {
  KSP ksp = nullptr;
  Mat matrix = nullptr;
  ::Vec x = nullptr, b = nullptr;
  MatNullSpace null_space = nullptr;
  StopCriterion criterion;
  StallTest stall;
  /// True if the preconditioner is the multigrid, with which some methods stagnate.
  bool may_stall = false;
  /// Iterations of earlier starts of the method in this solve.
  int iterations_before = 0;
  /// Relative tolerance from the option -field_ksp_rtol, if given.
  std::optional<double> rtol;
  /// True if the method computes the natural norm; otherwise the stop criterion does.
  bool has_natural_norm = true;

  Krylov() = default;
  Krylov(const Krylov&) = delete;
  Krylov& operator=(const Krylov&) = delete;
  ~Krylov() { release(); }
  /// Destroys the PETSc objects of this struct: method, matrix, vectors and null space.
  void release();

  /// Makes a matrix given by a function, a PETSc shell matrix for vectors of n entries.
  void make_shell_matrix(const Shell& shell, PetscInt n);
  /// Makes a KSP of the type `cg` with a preconditioner given by a function. If PETSc's options choose no
  /// preconditioner (-field_pc_type none) and no other KSP type, the type becomes plain CG. Throws InputError, and
  /// releases everything, if they name any other preconditioner, because the matrix is not stored.
  void make_shell_method(const Shell& shell, double tolerance, KSPType cg);
  /// Sets the KSP type `cg`, the relative `tolerance` and the stop criterion, then PETSc's options with prefix
  /// "field_". If they choose another method, the criterion remains, with a norm and an initial guess that the method
  /// supports. The option -field_ksp_rtol overrules the tolerance of each solve.
  void set_options(double tolerance, KSPType cg = KSPCG);
  /// Computes sqrt(r' M r) of the current iterate's residual r while the method runs (M: preconditioner).
  double natural_norm_of_iterate() const;
  /// Sets the null space of the matrix and takes ownership of `space`; null means a regular matrix.
  void set_null_space(MatNullSpace space);
  /// Sets the null space of equal potentials, for a system without ground. mark(entries) writes 1 for every unknown,
  /// else 0.
  template <class Mark>
  void set_constant_null_space(Mark mark) {
    ::Vec ones = nullptr;
    parallel::check_petsc(VecDuplicate(x, &ones));
    mark(static_cast<double*>(WriteAccess(ones)));
    MatNullSpace space = nullptr;
    parallel::check_petsc(VecNormalize(ones, nullptr));
    parallel::check_petsc(MatNullSpaceCreate(PETSC_COMM_WORLD, PETSC_FALSE, 1, &ones, &space));
    parallel::check_petsc(VecDestroy(&ones));
    set_null_space(space);
  }
  /// Returns true if the Krylov method is of this KSP type of PETSc.
  bool is(KSPType type) const;
  /// Solves the system from the guess in x until the criterion is met. Sets iterations and residual of `solution`. A
  /// method without the natural norm may stagnate or stop early. It then restarts from the true residual of its
  /// iterate, while each start halves the norm (iterative refinement). Throws Failure without convergence, or if
  /// numbers exceed double precision.
  void solve(LaplaceSolution& solution);

 private:
  void require_shell();
  void require_own_method(KSPType cg);
  void choose_norm();
  KSPConvergedReason solve_with_restarts();
};

/// Checks that all PETSc options for the field solver were used. Throws InputError for an unused option -field_..., and
/// for an unused -ksp_... or -pc_... without the prefix. To be called after a solve, which reads all its options.
void check_petsc_options();

}  // namespace lichtenberg::laplace
