#pragma once

#include <array>
#include <cmath>
#include <string_view>

#include "solvers/geometry/vec.hpp"

namespace lichtenberg {

/// Boundary condition at a side of a box: insulating wall, electrode of given potential, or periodic continuation.
enum class Boundary { wall, electrode, periodic };

/// Names of the sides of a box in the order of their indices. The lower side of each axis x, y, z precedes the upper
/// one. A box of the plane has the first four.
inline constexpr std::array<std::string_view, 6> side_names = {"left", "right", "bottom", "top", "front", "back"};

/// Periodic image of a particle: the net number of times it has crossed the periodic box, along each of d axes. The
/// particle's unwrapped position is position + image * length.
template <int d>
using Image = std::array<int, d>;

template <int d>
struct Box;

/// Minimum-image convention: maps a difference of positions along an axis to that of the nearest periodic images. It
/// stores lengths and inverse lengths of a box, so that loops need no branches. Along an axis that is not periodic both
/// are 0, and the difference does not change.
template <int d>
struct NearestImage {
  Vec<d> length, inverse_length;

  LICHTENBERG_HOST_DEVICE constexpr explicit NearestImage(const Box<d>& box) {
    for (int k = 0; k < d; ++k)
      if (box.periodic(k)) length[k] = box.lengths[k], inverse_length[k] = 1 / box.lengths[k];
  }
  /// Returns the difference of coordinates `separation` (m) along `axis`, reduced to the nearest image if the axis is
  /// periodic.
  LICHTENBERG_HOST_DEVICE double operator()(double separation, int axis) const {
    return separation - length[axis] * std::nearbyint(separation * inverse_length[axis]);
  }
};

/// Simulation box: a rectangle (d = 2) or cuboid (d = 3) with its lower corner at the origin, and the boundary
/// condition of each side. An axis is periodic on both sides or on none. By default all sides are walls.
template <int d>
struct Box {
  Vec<d> lengths;                       ///< Lengths (m)
  std::array<Boundary, 2 * d> sides{};  ///< Sides in the order of side_names

  /// Returns true if the box is periodic along this axis (0: x, 1: y, 2: z).
  LICHTENBERG_HOST_DEVICE constexpr bool periodic(int axis) const { return sides[2 * axis] == Boundary::periodic; }
  LICHTENBERG_HOST_DEVICE constexpr bool any_periodic() const {
    for (int k = 0; k < d; ++k)
      if (periodic(k)) return true;
    return false;
  }

  /// Returns the minimum-image separation a - b (m): the vector to position a from the nearest periodic image of
  /// position b.
  LICHTENBERG_HOST_DEVICE Vec<d> difference(Vec<d> a, Vec<d> b) const {
    const NearestImage<d> nearest(*this);
    Vec<d> r = a - b;
    for (int k = 0; k < d; ++k) r[k] = nearest(r[k], k);
    return r;
  }

  /// Wraps a position p (m) into the box: along each periodic axis afterwards 0 <= p < length. Adds the numbers of
  /// removed periods to `image`, so that p + image * lengths changes by rounding only.
  LICHTENBERG_HOST_DEVICE void wrap(Vec<d>& p, Image<d>& image) const {
    for (int k = 0; k < d; ++k) {
      if (!periodic(k) || (p[k] >= 0 && p[k] < lengths[k])) continue;
      const double periods = std::floor(p[k] / lengths[k]);
      p[k] -= periods * lengths[k];
      image[k] += static_cast<int>(periods);
      // Rounding may leave the coordinate slightly below 0, or put it on the upper side.
      if (p[k] < 0) p[k] = 0;
      if (p[k] >= lengths[k]) p[k] = 0, ++image[k];
    }
  }
};

}  // namespace lichtenberg
