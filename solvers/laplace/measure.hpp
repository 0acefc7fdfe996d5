#pragma once

#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

/// Scales that make the errors of a field solution relative: the largest potential difference, charge and force of the
/// solution. With them a single relative error describes the accuracy. Differences of charges and forces within
/// rounding do not count as errors.
struct Scales {
  double potential = 0;  ///< Largest difference of any two groups and electrode sides (V); 0 within rounding
  double charge = 0;     ///< Largest charge of a body (C; C/m in the plane)
  double force = 0;      ///< Largest force on a movable disk or sphere (N; N/m in the plane); infinite if there is none
  double charge_rounding = 0, force_rounding = 0;  ///< Differences up to these values do not count as errors

  /// Returns the relative error for the absolute difference of two charges (C; C/m in the plane): 0 within rounding,
  /// otherwise the difference over the charge scale (at least the rounding level).
  double error_of_charge(double difference) const;
  /// Returns the relative error for the absolute difference of two forces (N; N/m in the plane): 0 within rounding,
  /// otherwise the difference over the force scale (at least the rounding level).
  double error_of_force(double difference) const;
};

/// Rounding level of charges, in units of eps V, and of forces, in units of eps V^2 / L. Here eps is the permittivity,
/// V the potential scale and L the longer side of the box. Without this level, values that cancel by symmetry would
/// require unlimited accuracy.
inline constexpr double share_of_rounding = 1e-11;

/// Limit of small charges, in units of eps V, and of small forces, in units of eps V^2 / L. Here eps is the
/// permittivity, V the potential scale and L the longer side of the box. Values below it are small sums of large terms.
/// For these, the error of a method that controls potentials can exceed its tolerance.
inline constexpr double small_share = 1e-3;
/// Limits of small charges (C/m) and forces (N/m): values below them are small sums of large terms (small_share).
struct SmallValues {
  double charge = 0, force = 0;
};
/// Computes the limits of small charges and forces (small_share) for a problem with the potential scale of `scales`.
SmallValues small_values(const LaplaceProblem& problem, const Scales& scales);

/// Returns true if the force on a body counts in measures of accuracy: the body is a disk and movable
/// (LaplaceProblem::movable).
bool has_force(const LaplaceProblem& problem, std::size_t body);

/// Returns the largest difference between any two of the potentials (V); 0 if it is within rounding, NaN if one is not
/// finite.
double largest_difference(const std::vector<double>& potentials);

/// Computes the scales of a solution: its largest potential difference, charge and force.
Scales scales_of(const LaplaceProblem& problem, const LaplaceSolution& solution);

/// Computes the relative error of a solution compared with a reference. It is the largest difference of any group
/// potential, body charge or force on a movable disk, each divided by its scale. Differences of charges and forces
/// within rounding do not count, and their scales are at least the rounding level. Returns 0 if everything has the same
/// potential, to rounding. Forces on other bodies are excluded, because a bar's corners make its field singular.
/// Charges of sides are excluded, because they are infinite where electrodes of different potential meet.
double largest_error(const LaplaceProblem& problem, const LaplaceSolution& solution, const LaplaceSolution& reference,
                     const Scales& scales);

}  // namespace lichtenberg::laplace
