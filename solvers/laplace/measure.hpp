#pragma once

#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

/// The units of errors, so that one number says how accurate a solution is. Each largest value is that of the solution
/// at hand, however small it is; a difference is an error only above `rounding`.
struct Scales {
  double potential = 0;  ///< V, the largest difference between any two groups and electrode sides; 0 within rounding
  double charge = 0;     ///< C (C/m in the plane), the largest charge of a body
  double force = 0;      ///< N (N/m), the largest force on a disk or sphere that can move; infinite without any
  double charge_rounding = 0, force_rounding = 0;  ///< no difference below these is an error

  /// In units of the largest, which counts as no less than rounding.
  double error_of_charge(double difference) const;
  double error_of_force(double difference) const;
};

/// V being the potential scale and L the box's longer side, rounding is `share_of_rounding` of eps V for charges and of
/// eps V^2 / L for forces: what cancels by symmetry would else ask for the impossible.
inline constexpr double share_of_rounding = 1e-11;

/// Charges below this share of eps V, and forces below this share of eps V^2 / L, are small beside what makes them: the
/// error of a method that controls potentials can be more than its tolerance of them.
inline constexpr double small_share = 1e-3;
struct SmallValues {
  double charge = 0, force = 0;  ///< C/m, N/m
};
SmallValues small_values(const LaplaceProblem& problem, const Scales& scales);

/// Whether the force on a body counts: on a disk that can move (LaplaceProblem::movable).
bool has_force(const LaplaceProblem& problem, std::size_t body);

/// V, between any two; 0 within rounding.
double largest_difference(const std::vector<double>& potentials);

Scales scales_of(const LaplaceProblem& problem, const LaplaceSolution& solution);

/// Definition of "accurate to a": no potential of a group, charge of a body or force on a movable disk differs from the
/// reference by more than a times its scale, rounding apart. Returns the least such a; 0 if everything has the same
/// potential, to rounding.
///
/// Forces on other bodies are left out (a bar's corners make its field singular), and so are the sides' charges
/// (infinite where electrodes of different potential meet).
double largest_error(const LaplaceProblem& problem, const LaplaceSolution& solution, const LaplaceSolution& reference,
                     const Scales& scales);

}  // namespace lichtenberg::laplace
