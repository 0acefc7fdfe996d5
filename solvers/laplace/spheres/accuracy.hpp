#pragma once

#include <functional>

#include "solvers/laplace/measure.hpp"
#include "solvers/laplace/spheres/spheres.hpp"

namespace lichtenberg::laplace {

/// Computes the scales that make errors relative (../measure.hpp). They are the largest potential difference between
/// groups, electrodes and (in free space) infinity, the largest charge, and the largest force on a movable sphere. In a
/// uniform field the first is at least its difference over the extent of all spheres.
Scales scales_of(const SphereProblem& problem, const SphereSolution& solution);
/// Computes the relative error of a solution compared with a reference. It is the largest difference of a group
/// potential, a charge or a force on a movable sphere, each divided by its scale. Differences of charges and forces
/// within rounding do not count. Returns 0 if everything has the same potential.
double largest_error(const SphereProblem& problem, const SphereSolution& solution, const SphereSolution& reference,
                     const Scales& scales);

/// Solution of a problem of spheres, with an estimate of its error.
struct AccurateSpheres {
  double tolerance = 0;  ///< `SphereOptions::accuracy` of the solution
  double estimate = 0;   ///< Estimated error: difference from a solution at a finer tolerance
  SphereSolver solver;   ///< Solver after this solution, for its field()
  SphereSolution solution;
};

/// Solves a problem of spheres to a requested accuracy: repeats the solve at decreasing tolerances until the difference
/// from a finer solution is below `accuracy` (relative error as in largest_error). `solver_for` makes a solver for a
/// tolerance. Throws InputError if rounding excludes the accuracy or no finer solution is possible. Also throws the
/// exceptions of SphereSolver::solve.
AccurateSpheres solve_to_accuracy(const SphereProblem& problem, double accuracy,
                                  const std::function<SphereSolver(double tolerance)>& solver_for);

}  // namespace lichtenberg::laplace
