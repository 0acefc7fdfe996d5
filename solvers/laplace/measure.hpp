#pragma once

#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

/// Scales of errors: one relative error describes the accuracy of a solution. Each scale is the largest value of the
/// solution, however small. Differences count as errors only above the rounding.
struct Scales {
  double potential = 0;  ///< Largest difference of any two groups and electrode sides (V); 0 within rounding
  double charge = 0;     ///< Largest charge of a body (C; C/m in the plane)
  double force = 0;      ///< Largest force on a movable disk or sphere (N; N/m in the plane); infinite if there is none
  double charge_rounding = 0, force_rounding = 0;  ///< Differences up to these values do not count as errors

  /// Returns the difference relative to the largest value, which counts as at least the rounding.
  double error_of_charge(double difference) const;
  double error_of_force(double difference) const;
};

/// Rounding of charges and forces: this share of eps V for charges and of eps V^2 / L for forces, with V the potential
/// scale and L the box's longer side. Without it, values that cancel by symmetry would require unlimited accuracy.
inline constexpr double share_of_rounding = 1e-11;

/// Limit of small values. Charges below this share of eps V, and forces below this share of eps V^2 / L, are small sums
/// of large terms. For these, the error of a method that controls potentials can exceed its tolerance.
inline constexpr double small_share = 1e-3;
struct SmallValues {
  double charge = 0, force = 0;  ///< Charge (C/m) and force (N/m)
};
SmallValues small_values(const LaplaceProblem& problem, const Scales& scales);

/// Returns true if the force on a body counts: on a movable disk (LaplaceProblem::movable).
bool has_force(const LaplaceProblem& problem, std::size_t body);

/// Returns the largest difference of any two potentials (V); 0 within rounding.
double largest_difference(const std::vector<double>& potentials);

Scales scales_of(const LaplaceProblem& problem, const LaplaceSolution& solution);

/// Returns the error of a solution, the least a with which it is "accurate to a". This means that no group potential,
/// body charge or force on a movable disk differs from the reference by more than a times its scale, apart from
/// rounding. Returns 0 if everything has the same potential, to rounding.
/// Forces on other bodies are excluded (a bar's corners make its field singular). Charges of sides are excluded too
/// (infinite where electrodes of different potential meet).
double largest_error(const LaplaceProblem& problem, const LaplaceSolution& solution, const LaplaceSolution& reference,
                     const Scales& scales);

}  // namespace lichtenberg::laplace
