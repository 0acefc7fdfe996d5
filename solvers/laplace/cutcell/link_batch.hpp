#pragma once

// link.hpp's log-fitted links of one disk, several at a time, as vector instructions: most of what a grid's set-up
// takes are their angles and logarithms, which the C library gives one by one.

#include <array>

namespace lichtenberg::laplace {

/// Fluid cells beside a disk and, for each, where the covered cell lies. Lengths in cells.
struct LinkBatch {
  static constexpr int width = 8;
  std::array<double, width> x{}, y{};    ///< the fluid cell's centre, from the disk's
  std::array<double, width> ex{}, ey{};  ///< unit vector towards the covered cell
};

/// Conductances and their derivatives with respect to the disk's position.
struct BatchConductances {
  std::array<double, LinkBatch::width> value, gradient_x, gradient_y;
};

/// Radius (cells) of a disk from which on batches see it from its outside: between a fluid centre and a covered one,
/// whose face ends half a diagonal from both, its centre is .09 or more from either end and .3 from the middle. So a
/// face is seen under less than 2.1, and a fluid centre lies within 2.25 radii.
inline constexpr double least_batched_radius = 0.8;

/// log_fitted_link for each, to rounding.
BatchConductances log_fitted_links(const LinkBatch& links, double radius);

}  // namespace lichtenberg::laplace
