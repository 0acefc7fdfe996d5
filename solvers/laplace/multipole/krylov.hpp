#pragma once

#include <Eigen/Core>

namespace lichtenberg::laplace::multipole {

class System;

struct KrylovResult {
  int iterations = 0;
  double residual = 0;  ///< Norm of the preconditioned residual over that of the preconditioned right-hand side
  double scale = 0;     ///< Norm of the preconditioned right-hand side (V)
};

/// Solves the system by GMRES (Eigen's), with x as the initial guess. Throws Failure if it does not reach the
/// tolerance.
KrylovResult solve_krylov(const System& system, const Eigen::VectorXd& right_hand_side, double tolerance,
                          Eigen::VectorXd& x);

}  // namespace lichtenberg::laplace::multipole
