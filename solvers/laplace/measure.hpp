#pragma once

#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

/// The unit of each quantity's error, so that one number says how accurate a solution is.
struct Scales {
  double potential = 0;  ///< V, the largest difference between any two groups and electrode sides; 0 within rounding
  double charge = 0;     ///< C/m, the largest charge of a body, at least 1e-3 eps V
  double force = 0;      ///< N/m, the largest force on a disk, at least 1e-3 eps V^2 over the box's longer side
};

/// The lower limits, V being the potential scale, keep what cancels by symmetry from asking for the impossible.
Scales scales_of(const LaplaceProblem& problem, const LaplaceSolution& solution);

/// What "accurate to a" means: the largest difference, in units of the scales, between any group's potential, any
/// body's charge and any disk's force in the two solutions of one problem. 0 if everything has the same potential,
/// to rounding.
///
/// Forces on other bodies are left out (a bar's corners make its field singular), and so are the sides' charges
/// (infinite where electrodes of different potential meet).
double largest_error(const LaplaceProblem& problem, const LaplaceSolution& solution, const LaplaceSolution& reference,
                     const Scales& scales);

}  // namespace lichtenberg::laplace
