#pragma once

// Conjugate gradients with their scalars on the device: the host starts the loop and reads its end. They are a KSP
// type, so that stop criterion, monitors and options are those of any other; -field_ksp_type cg chooses PETSc's own.

#include <cmath>
#include <limits>

#include "solvers/geometry/host_device.hpp"
#include "solvers/laplace/cutcell/fused_iteration.hpp"

namespace lichtenberg::laplace::device {

/// State of the conjugate gradients in device memory: the device writes it, the host reads it at the end.
struct Iterations {
  StopCriterion criterion;
  CgScalars cg;
  /// Factor by which the initial guess was multiplied.
  double factor;
  /// Length of the last step.
  double alpha;
  /// Maximum number of iterations.
  int most;
  /// Number of iterations so far; KSPConvergedReason of PETSc, 0 while iterating.
  int done, reason;
  /// 1 if another iteration follows, else 0.
  int go_on;
  static constexpr int kept = 512;
  /// Natural norms sqrt(r'z) of the first iterations.
  double norm[kept];

  /// Resets the state. `tolerance`: relative error in the energy norm; `most_`: maximum number of iterations.
  LICHTENBERG_HOST_DEVICE void begin(double tolerance, int most_) {
    criterion = {};
    criterion.tolerance = tolerance;
    cg = {};
    most = most_;
    factor = alpha = 0;
    done = reason = go_on = 0;
  }
  /// Computes the factor that minimizes the error of the initial guess x in the energy norm, and the scaled guess's
  /// energy norm and rounding level. `product`: b'x; `energy`: x'A x; `largest`: maximum of |x|; n: number of entries
  /// of x. The rounding level is that of CpuSolver::rounding_of_residual.
  LICHTENBERG_HOST_DEVICE void set_guess_scale(double product, double energy, double largest, double n) {
    factor = energy > 0 ? product / energy : 0.0;
    const double squared = factor * product;
    criterion.energy_norm = squared > 0 ? std::sqrt(squared) : 0.0;
    criterion.rounding = 0x1p-52 * std::sqrt(n) * largest * std::abs(factor);
  }
  /// Sets the energy norm of the scaled guess from `energy`, the part of x'A x without couplings (lumped capacitances).
  LICHTENBERG_HOST_DEVICE void set_energy_of_field(double energy) {
    criterion.energy_norm = std::abs(factor) * (energy > 0 ? std::sqrt(energy) : 0.0);
  }
  /// Adds the rounding error of a common shift of all n potentials to the rounding level. `shift`: its magnitude.
  LICHTENBERG_HOST_DEVICE void raise_rounding(double shift, double n) {
    criterion.rounding += 0x1p-52 * std::sqrt(n) * shift;
  }
  /// Tests convergence by the scalar product r'z, `product`. Updates beta, the norms, the number of iterations,
  /// `reason` and `go_on`.
  LICHTENBERG_HOST_DEVICE void test_convergence(double product) {
    const bool first = cg.residuals == 0;
    cg.add(product);
    const double now = std::sqrt(std::abs(product));
    if (first)
      criterion.begin(now);
    else
      ++done;
    if (done < kept) norm[done] = now;
    if (!(now < infinite))
      reason = KSP_DIVERGED_NANORINF;
    else if (!first && product < 0)
      reason = KSP_DIVERGED_INDEFINITE_PC;
    else if (criterion.is_met_by(now))
      reason = first ? KSP_CONVERGED_ATOL : KSP_CONVERGED_RTOL;
    else if (done >= most)
      reason = KSP_DIVERGED_ITS;
    go_on = reason == 0;
  }
  /// Computes the step length from the scalar product p'A p; it is 0 if the iterations have ended or p'A p is not
  /// positive. Except for the first step, predicts whether the step is the last, as predict_end in
  /// ../fused_iteration.hpp.
  LICHTENBERG_HOST_DEVICE void set_step(double curvature) {
    alpha = 0;
    if (reason != 0) return;
    alpha = curvature > 0 ? cg.product / curvature : 0.0;
    if (!(curvature > 0)) reason = KSP_DIVERGED_INDEFINITE_MAT;
    const double predicted = cg.predicted_norm(CgScalars::slow_step);
    if (reason == 0 && done > 0 && criterion.is_met_by(predicted)) {
      reason = KSP_CONVERGED_RTOL;
      if (++done < kept) norm[done] = predicted;
    }
    go_on = reason == 0;
  }

 private:
  static constexpr double infinite = std::numeric_limits<double>::infinity();
};

/// Solve function of a PETSc KSP whose iterations run on the device. The KSP's preconditioner must be a shell with a
/// Solver as context. Returns PETSc's error code.
template <class Solver>
PetscErrorCode iterate_on_device(KSP method) {
  Solver* solver = nullptr;
  PetscCall(PCShellGetContext(method->pc, &solver));
  return solver->iterate_as_ksp(method);
}

}  // namespace lichtenberg::laplace::device
