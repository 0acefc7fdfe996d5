#pragma once

#include <petscksp.h>

#include <cmath>
#include <optional>

#include "solvers/geometry/host_device.hpp"
#include "solvers/laplace/cutcell/shell.hpp"
#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

/// Stop criterion: the natural norm sqrt(r' M r) of CG estimates the energy norm of the error, and is compared with the
/// energy norm of the solution. The plain residual has no such bound: a short link, from a cell centre close to a
/// conductor, makes it arbitrarily large.
struct StopCriterion {
  double tolerance = 0;
  double energy_norm = 0;  ///< of the initial guess
  double scale = 0;        ///< estimate of the solution's energy norm
  double last = 0;         ///< last norm divided by the scale
  /// Norm of a residual that is only rounding; it matters where all potentials are equal, so that the energy is zero.
  double rounding = 0;

  /// Sets the scale from the norm of the first residual, which adds to the energy of the guess.
  LICHTENBERG_HOST_DEVICE void begin(double norm) { scale = std::hypot(energy_norm, norm); }
  void record(double norm) { last = scale > 0 ? norm / scale : 0.0; }
  LICHTENBERG_HOST_DEVICE bool is_met_by(double norm) const {
    const double relative = tolerance * scale;
    return norm <= (relative < rounding ? rounding : relative);
  }
};

/// Scalars of the conjugate gradients, for the CPU and a device.
struct CgScalars {
  double product = 0;            ///< r'z of the last residual
  double beta = 0, largest = 0;  ///< ratio to the product before; the largest ratio
  int residuals = 0;             ///< number of products so far

  LICHTENBERG_HOST_DEVICE void add(double next) {
    beta = residuals > 0 ? next / product : 0.0;
    largest = beta > largest ? beta : largest;
    product = next;
    ++residuals;
  }
  /// Predicts the norm after the step from the last residual: the step reduces the norm by the factor `slow`, or as
  /// little as the slowest step so far. If the prediction meets the criterion, the next V-cycle, 5/6 of an iteration,
  /// would only confirm it.
  LICHTENBERG_HOST_DEVICE double predicted_norm(double slow) const {
    const double slowest = std::sqrt(largest);
    return (slowest > slow ? slowest : slow) * std::sqrt(std::abs(product));
  }
  /// Reduction of a slow step: the slowest of 1000 steps in moving scenes; most reduced the norm to a quarter.
  static constexpr double slow_step = 0.5;
};

/// Detects that a method no longer reduces the true residual. The geometric multigrid works in single precision and is
/// no exactly linear map, so that short recurrences that rely on one (MINRES, BiCGStab) stagnate. While a method
/// converges with it, an iteration halves the norm or does better.
struct StallTest {
  double best = 0;
  int iterations = 0;  ///< iterations since `best`

  void start(double norm) { best = norm, iterations = 0; }
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

/// PETSc's KSP with its matrix and vectors.
struct Krylov {
  KSP ksp = nullptr;
  Mat matrix = nullptr;
  ::Vec x = nullptr, b = nullptr;
  MatNullSpace null_space = nullptr;
  StopCriterion criterion;
  StallTest stall;
  bool may_stall = false;        ///< the preconditioner is the multigrid
  int iterations_before = 0;     ///< of earlier starts of this solve
  std::optional<double> rtol;    // -field_ksp_rtol
  bool has_natural_norm = true;  ///< the method computes it; else the stop criterion does

  Krylov() = default;
  Krylov(const Krylov&) = delete;
  Krylov& operator=(const Krylov&) = delete;
  ~Krylov() { release(); }
  void release();

  /// Makes a shell matrix for vectors of n entries.
  void make_shell_matrix(const Shell& shell, PetscInt n);
  /// Makes a KSP of the type `cg` with a shell as preconditioner. If options name a preconditioner of PETSc, the type
  /// becomes plain CG. Throws InputError, and releases everything, if that preconditioner needs a matrix.
  void make_shell_method(const Shell& shell, double tolerance, KSPType cg);
  /// Sets the KSP type `cg` and the stop criterion above, then the options with prefix "field_". Any method of PETSc
  /// keeps the criterion, with a norm and an initial guess that it supports. -field_ksp_rtol overrules the tolerance of
  /// every criterion.
  void set_options(double tolerance, KSPType cg = KSPCG);
  /// Returns sqrt(r' M r) of the iterate's residual r while the method runs.
  double natural_norm_of_iterate() const;
  /// Takes ownership of `space`; null: the matrix is regular.
  void set_null_space(MatNullSpace space);
  /// Sets the null space of equal potentials: mark(entries) writes 1 for every unknown, else 0.
  template <class Mark>
  void set_constant_null_space(Mark mark) {
    ::Vec ones = nullptr;
    parallel::check_petsc(VecDuplicate(x, &ones));
    mark(static_cast<double*>(WriteAccess(ones)));
    MatNullSpace space = nullptr;
    parallel::check_petsc(VecNormalize(ones, nullptr));
    parallel::check_petsc(MatNullSpaceCreate(PETSC_COMM_SELF, PETSC_FALSE, 1, &ones, &space));
    parallel::check_petsc(VecDestroy(&ones));
    set_null_space(space);
  }
  /// Returns true if the method has this KSP type.
  bool is(KSPType type) const;
  /// Solves from the guess in x until the criterion is met; sets iterations and residual of `solution`. A method that
  /// stagnates or breaks down restarts from the true residual of its iterate (iterative refinement) while that halves
  /// the norm. Throws Failure without convergence, or if numbers exceed double precision.
  void solve(LaplaceSolution& solution);

 private:
  void require_shell();
  void choose_norm();
  KSPConvergedReason solve_with_restarts();
};

/// Throws InputError if an option for the field solver is unused: -field_..., or -ksp_... and -pc_... without the
/// prefix. To be called after a solve, which reads all its options.
void check_petsc_options();

}  // namespace lichtenberg::laplace
