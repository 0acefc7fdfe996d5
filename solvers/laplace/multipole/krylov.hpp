#pragma once

#include <Eigen/Core>

namespace lichtenberg::laplace::multipole {

class System;

struct KrylovResult {
  int iterations = 0;
  double residual = 0;  ///< |preconditioned residual| / |preconditioned right-hand side|
  double scale = 0;     ///< the latter, V
};

/// GMRES (Eigen's) on the system from the first guess x. Throws Failure if it doesn't reach the tolerance.
KrylovResult solve_krylov(const System& system, const Eigen::VectorXd& right_hand_side, double tolerance,
                          Eigen::VectorXd& x);

}  // namespace lichtenberg::laplace::multipole
