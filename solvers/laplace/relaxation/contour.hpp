#pragma once

#include <vector>

#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

/// Point of the closed contour around a body on which charge and force are integrated (Stephenson 2018, D 6.11).
struct ContourPoint {
  Vec2 at;         ///< Position (m)
  Vec2 normal_ds;  ///< Unit normal out of the body times the length of the contour that belongs to the point (m)
};

/// Makes the integration contour around body number `index`: a closed curve at distance `offset` (m) from its surface
/// (Stephenson 2018, D 6.11 for a disk). It has `points` points, or two per `spacing` (m) on long curves.
/// Near another body the curve is about halfway between the two surfaces, so that it encloses this body only. Where it
/// would leave the box it follows the side. Normals are central differences along the curve (D 6.12, corrected); their
/// sum
/// is zero for any curve.
std::vector<ContourPoint> contour(const LaplaceProblem& problem, std::size_t index, double offset, int points,
                                  double spacing);

}  // namespace lichtenberg::laplace
