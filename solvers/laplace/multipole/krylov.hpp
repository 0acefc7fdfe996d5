#pragma once

#include <Eigen/Core>

namespace lichtenberg::laplace::multipole {

class System;

/// Number of iterations of solve_krylov() and the residual that it reached.
struct KrylovResult {
  int iterations = 0;
  double residual = 0;  ///< Norm of the preconditioned residual over that of the preconditioned right-hand side
  double scale = 0;     ///< Norm of the preconditioned right-hand side (V)
};

/// Solves the linear system by preconditioned, restarted GMRES (Eigen). On entry x is the initial guess, on return the
/// solution. `tolerance`: norm of the preconditioned residual over that of the preconditioned right-hand side. Throws
/// Failure if the tolerance is not reached.
KrylovResult solve_krylov(const System& system, const Eigen::VectorXd& right_hand_side, double tolerance,
                          Eigen::VectorXd& x);

}  // namespace lichtenberg::laplace::multipole
