#pragma once

#include <array>
#include <cmath>
#include <string_view>

#include "solvers/geometry/vec.hpp"

namespace lichtenberg {

/// Kind of a side of a box.
enum class Boundary { wall, electrode, periodic };

/// Names of the sides in their order: for each axis the low one, then the high one. A plane box has the first four.
inline constexpr std::array<std::string_view, 6> side_names = {"left", "right", "bottom", "top", "front", "back"};

/// Number of periods by which a particle has crossed a periodic box, along each axis.
template <int d>
using Image = std::array<int, d>;

template <int d>
struct Box;

/// Maps a difference of positions to that of the nearest images: a box prepared for loops, without branches. Along
/// other axes the length is 0, and the difference does not change.
template <int d>
struct NearestImage {
  Vec<d> length, inverse_length;

  LICHTENBERG_HOST_DEVICE constexpr explicit NearestImage(const Box<d>& box) {
    for (int k = 0; k < d; ++k)
      if (box.periodic(k)) length[k] = box.lengths[k], inverse_length[k] = 1 / box.lengths[k];
  }
  LICHTENBERG_HOST_DEVICE double operator()(double separation, int axis) const {
    return separation - length[axis] * std::nearbyint(separation * inverse_length[axis]);
  }
};

/// Rectangle (d = 2) or cuboid (d = 3) with one corner at the origin. An axis is periodic on both sides or on none. By
/// default nothing is periodic, and differences do not depend on the lengths.
template <int d>
struct Box {
  Vec<d> lengths;                       ///< Lengths (m)
  std::array<Boundary, 2 * d> sides{};  ///< Sides in the order of side_names

  LICHTENBERG_HOST_DEVICE constexpr bool periodic(int axis) const { return sides[2 * axis] == Boundary::periodic; }
  LICHTENBERG_HOST_DEVICE constexpr bool any_periodic() const {
    for (int k = 0; k < d; ++k)
      if (periodic(k)) return true;
    return false;
  }

  /// Returns a - b for the image of b nearest to a.
  LICHTENBERG_HOST_DEVICE Vec<d> difference(Vec<d> a, Vec<d> b) const {
    const NearestImage<d> nearest(*this);
    Vec<d> r = a - b;
    for (int k = 0; k < d; ++k) r[k] = nearest(r[k], k);
    return r;
  }

  /// Moves p into the box along the periodic axes, 0 <= p < length, and adds the number of periods to `image`, so that
  /// p + image * lengths is unchanged.
  LICHTENBERG_HOST_DEVICE void wrap(Vec<d>& p, Image<d>& image) const {
    for (int k = 0; k < d; ++k) {
      if (!periodic(k) || (p[k] >= 0 && p[k] < lengths[k])) continue;
      const double periods = std::floor(p[k] / lengths[k]);
      p[k] -= periods * lengths[k];
      image[k] += static_cast<int>(periods);
      // Rounding may leave it slightly below 0, or put it on the far side.
      if (p[k] < 0) p[k] = 0;
      if (p[k] >= lengths[k]) p[k] = 0, ++image[k];
    }
  }
};

}  // namespace lichtenberg
