#pragma once

// Log-fitted links (link.hpp) of one disk in batches, with vector instructions. Angles and logarithms dominate the cost
// of a grid's set-up, and the C library computes them one at a time.

#include <array>

namespace lichtenberg::laplace {

/// Fluid cells next to a disk, with the directions to its cells. Lengths in cells.
struct LinkBatch {
  static constexpr int width = 8;
  /// Centre of the fluid cell relative to the disk's.
  std::array<double, width> x{}, y{};
  /// Unit vector towards the covered cell.
  std::array<double, width> ex{}, ey{};
};

/// Conductances and derivatives with respect to the disk's position.
struct BatchConductances {
  std::array<double, LinkBatch::width> value, gradient_x, gradient_y;
};

/// Minimum radius (cells) of a disk for batches. The ends of the face between a fluid and a covered centre are half a
/// diagonal from both. At this radius the disk's centre is at least .09 from either end of a face and .3 from its
/// middle. A face then subtends less than 2.1 at the disk's centre, and fluid centres are within 2.25 radii.
inline constexpr double least_batched_radius = 0.8;

/// Returns log_fitted_link for each, except for rounding.
BatchConductances log_fitted_links(const LinkBatch& links, double radius);

}  // namespace lichtenberg::laplace
