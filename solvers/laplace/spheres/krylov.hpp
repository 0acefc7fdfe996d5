#pragma once

#include "solvers/laplace/spheres/system.hpp"

namespace lichtenberg::laplace::spheres {

struct KrylovResult {
  int iterations = 0;
  double residual = 0;  ///< relative to the right-hand side and the given charges
};

/// Conjugate gradients (PETSc's, options with the prefix spheres_) from the start x. Throws Failure without
/// convergence.
KrylovResult solve_krylov(const System& system, double tolerance, std::vector<double>& x);

}  // namespace lichtenberg::laplace::spheres
