#pragma once

#include <vector>

#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

/// A point of the closed curve round a body on which charge and force are integrated (D 6.11).
struct ContourPoint {
  Vec2 at;         ///< m
  Vec2 normal_ds;  ///< m: normal out of the body times the length of curve that belongs to the point
};

/// The integration curve of body `index`: the shape `offset` metres off its surface (for a disk D 6.11), in `points`
/// points, or as many as it takes to have two in every `spacing` of a long one. Where another body stands closer than
/// that, the curve keeps halfway between the two surfaces, so that it encloses this body only; where the box ends it
/// follows the side. Normals are central differences along the curve: (cos, sin) on a disk (D 6.12, corrected), and
/// their sum is zero however the curve was bent.
std::vector<ContourPoint> contour(const LaplaceProblem& problem, std::size_t index, double offset, int points,
                                  double spacing);

}  // namespace lichtenberg::laplace
