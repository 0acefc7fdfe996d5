#pragma once

#include <vector>

#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

/// Point of the closed curve around a body on which charge and force are integrated (D 6.11).
struct ContourPoint {
  Vec2 at;         ///< Position (m)
  Vec2 normal_ds;  ///< Normal out of the body times the length of the curve that belongs to the point (m)
};

/// Returns the integration curve of body `index`: the shape at distance `offset` (m) from its surface (for a disk D
/// 6.11). It has `points` points, or for long curves two per `spacing`. Near another body the curve runs halfway
/// between the two surfaces, so that it encloses this body only; at the end of the box it follows the side. Normals are
/// central differences along the curve: (cos, sin) on a disk (D 6.12, corrected). Their sum is zero for any curve.
std::vector<ContourPoint> contour(const LaplaceProblem& problem, std::size_t index, double offset, int points,
                                  double spacing);

}  // namespace lichtenberg::laplace
