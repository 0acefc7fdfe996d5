#pragma once

#include <functional>

#include "solvers/laplace/measure.hpp"
#include "solvers/laplace/spheres/spheres.hpp"

namespace lichtenberg::laplace {

/// Computes the scales of errors, as in the plane (../measure.hpp). Potentials are relative to the largest difference
/// between groups, electrodes and, if there is one, free space at infinity. Charges and forces are relative to the
/// largest of any sphere.
Scales scales_of(const SphereProblem& problem, const SphereSolution& solution);
double largest_error(const SphereProblem& problem, const SphereSolution& solution, const SphereSolution& reference,
                     const Scales& scales);

/// Solution of known error.
struct AccurateSpheres {
  double tolerance = 0;  ///< `SphereOptions::accuracy` of the solution
  double estimate = 0;   ///< Estimated error: difference from a solution at a finer tolerance
  SphereSolver solver;   ///< Solver that holds the solution
  SphereSolution solution;
};

/// Solves at decreasing tolerances from `accuracy` on until the error, relative to a finer solution, is at most
/// `accuracy`. `solver_for` makes a solver for a tolerance. Throws InputError if rounding excludes the accuracy or no
/// finer solution is possible. Also throws the exceptions of SphereSolver::solve.
AccurateSpheres solve_to_accuracy(const SphereProblem& problem, double accuracy,
                                  const std::function<SphereSolver(double tolerance)>& solver_for);

}  // namespace lichtenberg::laplace
