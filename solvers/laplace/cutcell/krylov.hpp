#pragma once

#include <petscksp.h>

#include <cmath>
#include <optional>

#include "solvers/geometry/host_device.hpp"
#include "solvers/laplace/cutcell/shell.hpp"
#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

/// The stop criterion: CG's natural norm sqrt(r' M r) estimates the energy norm of the error, and it is compared with
/// the energy norm of the solution. The plain residual would be useless here: a short link (a cell centre that all
/// but touches a conductor) makes it as large as it likes.
struct StopCriterion {
  double tolerance = 0;
  double energy_norm = 0;  ///< of the first guess; what the first residual adds is part of the solution's as well
  double scale = 0, last = 0;
  /// The norm that rounding alone gives a residual: where all potentials are one there is no energy to compare with.
  double rounding = 0;

  /// Sets the scale from the norm of the first residual.
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
  double beta = 0, largest = 0;  ///< its ratio to the one before; the largest of all ratios
  int residuals = 0;             ///< so far

  LICHTENBERG_HOST_DEVICE void add(double next) {
    beta = residuals > 0 ? next / product : 0.0;
    largest = beta > largest ? beta : largest;
    product = next;
    ++residuals;
  }
  /// The norm that the next step is expected to leave: it reduces the norm by the factor `slow`, or as the slowest step
  /// so far. If that meets the criterion, the next V-cycle, five sixths of an iteration, would only confirm it.
  LICHTENBERG_HOST_DEVICE double predicted_norm(double slow) const {
    const double slowest = std::sqrt(largest);
    return (slowest > slow ? slowest : slow) * std::sqrt(std::abs(product));
  }
  /// Of 1000 steps in scenes in motion none was slower than this, and most reduced the norm to a quarter.
  static constexpr double slow_step = 0.5;
};

/// Detects that a method no longer reduces the true residual. The geometric multigrid works in single precision, hence
/// it is no exactly linear map, and short recurrences that rely on one (MINRES, BiCGStab) stagnate. While a method
/// converges with it, an iteration halves the norm or does better.
struct StallTest {
  double best = 0;
  int iterations = 0;  ///< since `best`

  void start(double norm) { best = norm, iterations = 0; }
  bool is_stalled(double norm) {
    constexpr double progress = 0.9;
    constexpr int patience = 10;
    if (norm < progress * best)
      start(norm);
    else
      ++iterations;
    return iterations >= patience;
  }
};

/// A KSP with its matrix and vectors.
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
  bool has_natural_norm = true;  ///< the method iterates by it; else the stop criterion computes it

  Krylov() = default;
  Krylov(const Krylov&) = delete;
  Krylov& operator=(const Krylov&) = delete;
  ~Krylov() { release(); }
  void release();

  /// A shell matrix on vectors of n entries.
  void make_shell_matrix(const Shell& shell, PetscInt n);
  /// A KSP with a shell as preconditioner and the KSP type `cg`, which can have no other: with one of PETSc's, which
  /// options may name, plain CG. Throws InputError, and releases everything, if an option asks for a preconditioner
  /// that needs a matrix.
  void make_shell_method(const Shell& shell, double tolerance, KSPType cg);
  /// CG, of the KSP type `cg`, with the criterion above, then what the options with prefix "field_" say: any method of
  /// PETSc's keeps the criterion, with a norm and a first guess that it supports. -field_ksp_rtol overrules the
  /// tolerance of every criterion.
  void set_options(double tolerance, KSPType cg = KSPCG);
  /// sqrt(r' M r) of the residual r while the method iterates.
  double natural_norm_of_iterate() const;
  /// Takes over `space`; null: the matrix is regular.
  void set_null_space(MatNullSpace space);
  /// The null space of equal potentials: mark(entries) writes 1 on every unknown, else 0.
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
  /// Whether the method is of a KSP type.
  bool is(KSPType type) const;
  /// Solves from the guess in x until the criterion is met; sets iterations and residual of `solution`. A method that
  /// stagnates or breaks down starts again from the true residual of its iterate (iterative refinement), as long as
  /// that halves the norm. Throws Failure without convergence.
  void solve(LaplaceSolution& solution);

 private:
  void require_shell();
  void choose_norm();
  KSPConvergedReason solve_with_restarts();
};

/// To be called after a field solve, when all that concerns it has been asked for: throws InputError if one of the
/// options for PETSc was meant for the field solver (-field_..., or -ksp_... and -pc_... without the prefix) and is
/// unused.
void check_petsc_options();

}  // namespace lichtenberg::laplace
