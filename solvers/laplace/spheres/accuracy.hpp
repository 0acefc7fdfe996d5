#pragma once

#include <functional>

#include "solvers/laplace/measure.hpp"
#include "solvers/laplace/spheres/spheres.hpp"

namespace lichtenberg::laplace {

/// As of the plane (../measure.hpp): potentials over the largest difference of any two groups and electrodes, free
/// space at infinity among them, charges and forces over the largest of any sphere.
Scales scales_of(const SphereProblem& problem, const SphereSolution& solution);
double largest_error(const SphereProblem& problem, const SphereSolution& solution, const SphereSolution& reference,
                     const Scales& scales);

/// A solution of known error.
struct AccurateSpheres {
  double tolerance = 0;  ///< `SphereOptions::accuracy` of the solution
  double estimate = 0;   ///< of its error: how far it is from a solution at a finer tolerance
  SphereSolver solver;   ///< that of the solution
  SphereSolution solution;
};

/// Solves at tolerances from `accuracy` down until the error, measured beside a finer solution, is at most `accuracy`.
/// `solver_for` makes a solver of a tolerance. Throws InputError if rounding does not allow it or
/// no finer solution can be had, or as SphereSolver::solve does.
AccurateSpheres solve_to_accuracy(const SphereProblem& problem, double accuracy,
                                  const std::function<SphereSolver(double tolerance)>& solver_for);

}  // namespace lichtenberg::laplace
