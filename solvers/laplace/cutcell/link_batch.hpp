#pragma once

// Log-fitted links (link.hpp) of disks in batches, with vector instructions. Angles and logarithms dominate the cost
// of a grid's set-up, and the C library computes them one at a time.

#include <array>

namespace lichtenberg::laplace {

/// Geometry of links from fluid cells to disks, for vector instructions: two vectors of eight, so that the second need
/// not wait for the first. A link is the conductance between a fluid cell and a conductor. Lengths are in cells.
struct LinkBatch {
  static constexpr int width = 16;
  /// Centre of each fluid cell relative to the disk's centre.
  std::array<double, width> x{}, y{};
  /// Unit vector from each fluid cell to the neighbouring cell that the disk covers.
  std::array<double, width> ex{}, ey{};
  /// Radius of the disk, and its square.
  std::array<double, width> radius{}, radius2{};
};

/// Conductances of the links of a batch (per depth and permittivity) and their derivatives with respect to the disk's
/// position (per cell width).
struct BatchConductances {
  std::array<double, LinkBatch::width> value, gradient_x, gradient_y;
};

/// Minimum radius (cells) of a disk whose links are computed in batches. The ends of the face between a fluid and a
/// covered cell centre are half a diagonal from both. At this radius the disk's centre is at least .09 from either end
/// of a face and .3 from its middle. A face then subtends less than 2.1 rad at the disk's centre, and fluid cell
/// centres are within 2.25 radii.
inline constexpr double least_batched_radius = 0.8;

/// Computes the conductances of a batch of links from fluid cells to disks, and their derivatives. The results equal
/// those of log_fitted_link except for rounding.
BatchConductances log_fitted_links(const LinkBatch& links);

}  // namespace lichtenberg::laplace
