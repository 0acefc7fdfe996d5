#pragma once

// Conjugate gradients with their scalars on the device: a loop that the host starts and reads the end of. As a KSP, so
// that the stop criterion, monitors and options are those of any other; -field_ksp_type cg takes PETSc's own.

#include <cmath>
#include <limits>

#include "solvers/geometry/host_device.hpp"
#include "solvers/laplace/cutcell/fused_iteration.hpp"

namespace lichtenberg::laplace::device {

/// Where the iterations stand: written on the device, read by the host when they have stopped. The criterion is
/// ../krylov.hpp's.
struct Iterations {
  double tolerance;
  int most;
  double energy_norm, rounding;  ///< of the first guess; of its residual's norm
  double scale;                  ///< what norms are compared with
  double factor;                 ///< by which the first guess was multiplied
  double product, alpha, beta;   ///< r'z; of the last step
  double largest_beta;           ///< of all steps
  int judged;                    ///< whether any residual was
  int done, reason;              ///< iterations; KSPConvergedReason
  int go_on;
  static constexpr int kept = 512;
  double norm[kept];  ///< by iteration, of the first ones

  LICHTENBERG_HOST_DEVICE void begin(double tolerance_, int most_) {
    tolerance = tolerance_;
    most = most_;
    energy_norm = rounding = scale = factor = product = alpha = beta = largest_beta = 0;
    judged = done = reason = go_on = 0;
  }
  /// After the products b'x, x'A x and the largest |x| of n unknowns: the guess is multiplied such that its error is
  /// least. A row adds some five potentials of at most |x|, which leaves a residual of about epsilon |x|
  /// (../solver.cpp).
  LICHTENBERG_HOST_DEVICE void take_guess(double product_, double energy, double largest, double n) {
    factor = energy > 0 ? product_ / energy : 0.0;
    const double squared = factor * product_;
    energy_norm = squared > 0 ? std::sqrt(squared) : 0.0;
    rounding = 0x1p-52 * std::sqrt(n) * largest * std::abs(factor);
  }
  /// After take_guess, where groups are coupled: what couplings to given potentials have in x'A x is no measure of the
  /// field.
  LICHTENBERG_HOST_DEVICE void set_energy_of_field(double energy) {
    energy_norm = std::abs(factor) * (energy > 0 ? std::sqrt(energy) : 0.0);
  }
  /// All potentials have been shifted by so much.
  LICHTENBERG_HOST_DEVICE void raise_rounding(double shift, double n) { rounding += 0x1p-52 * std::sqrt(n) * shift; }
  /// After the product r'z.
  LICHTENBERG_HOST_DEVICE void judge(double next) {
    const bool first = judged == 0;
    judged = 1;
    beta = first ? 0.0 : next / product;
    largest_beta = beta > largest_beta ? beta : largest_beta;
    product = next;
    done += !first;
    const double now = std::sqrt(std::abs(next));
    if (done < kept) norm[done] = now;
    if (first) scale = std::sqrt(energy_norm * energy_norm + now * now);
    if (!(now < infinite))
      reason = KSP_DIVERGED_NANORINF;
    else if (!first && next < 0)
      reason = KSP_DIVERGED_INDEFINITE_PC;
    else if (now <= enough())
      reason = first ? KSP_CONVERGED_ATOL : KSP_CONVERGED_RTOL;
    else if (done >= most)
      reason = KSP_DIVERGED_ITS;
    go_on = reason == 0;
  }
  /// After the product p'A p; the step is none where the residual is small enough already. Whether the step is the last
  /// one is foreseen (foresee_end in ../fused_iteration.hpp).
  LICHTENBERG_HOST_DEVICE void set_step(double curvature) {
    alpha = 0;
    if (reason != 0) return;
    alpha = curvature > 0 ? product / curvature : 0.0;
    if (!(curvature > 0)) reason = KSP_DIVERGED_INDEFINITE_MAT;
    constexpr double slow = 0.25;  // of the norm squared
    const double foreseen = std::sqrt((largest_beta > slow ? largest_beta : slow) * std::abs(product));
    if (reason == 0 && done > 0 && foreseen <= enough()) {
      reason = KSP_CONVERGED_RTOL;
      if (++done < kept) norm[done] = foreseen;
    }
    go_on = reason == 0;
  }

 private:
  LICHTENBERG_HOST_DEVICE double enough() const { return tolerance * scale > rounding ? tolerance * scale : rounding; }
  static constexpr double infinite = std::numeric_limits<double>::infinity();
};

/// KSPSolve of the method; its preconditioner must be a shell whose context is a Solver.
template <class Solver>
PetscErrorCode iterate_on_device(KSP method) {
  Solver* solver = nullptr;
  PetscCall(PCShellGetContext(method->pc, &solver));
  return solver->iterate_as_ksp(method);
}

}  // namespace lichtenberg::laplace::device
