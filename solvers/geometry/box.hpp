#pragma once

#include <array>
#include <cmath>
#include <string_view>

#include "solvers/geometry/vec.hpp"

namespace lichtenberg {

/// What a side of a box is to what is inside.
enum class Boundary { wall, electrode, periodic };

/// Sides in the order in which a box has them: each axis' low one, then its high one. A plane box has the first four.
inline constexpr std::array<std::string_view, 6> side_names = {"left", "right", "bottom", "top", "front", "back"};

/// How many times something has gone once around a periodic box, along each axis.
template <int d>
using Image = std::array<int, d>;

template <int d>
struct Box;

/// Turns the difference of two places into that of their nearest images: a box prepared for loops. Without branches;
/// along axes that are not periodic the length is 0 and nothing changes.
template <int d>
struct NearestImage {
  Vec<d> length, turns_a_metre;

  LICHTENBERG_HOST_DEVICE constexpr explicit NearestImage(const Box<d>& box) {
    for (int k = 0; k < d; ++k)
      if (box.periodic(k)) length[k] = box.lengths[k], turns_a_metre[k] = 1 / box.lengths[k];
  }
  LICHTENBERG_HOST_DEVICE double operator()(double apart, int axis) const {
    return apart - length[axis] * std::nearbyint(apart * turns_a_metre[axis]);
  }
};

/// A rectangle (d = 2) or cuboid (d = 3) with one corner at the origin. An axis is periodic on both its sides or on
/// none. By default nothing is periodic, and the lengths mean nothing to who asks for differences.
template <int d>
struct Box {
  Vec<d> lengths;                       ///< m
  std::array<Boundary, 2 * d> sides{};  ///< as in side_names

  LICHTENBERG_HOST_DEVICE constexpr bool periodic(int axis) const { return sides[2 * axis] == Boundary::periodic; }
  LICHTENBERG_HOST_DEVICE constexpr bool any_periodic() const {
    for (int k = 0; k < d; ++k)
      if (periodic(k)) return true;
    return false;
  }

  /// a - b for the image of b that is nearest to a.
  LICHTENBERG_HOST_DEVICE Vec<d> difference(Vec<d> a, Vec<d> b) const {
    const NearestImage<d> nearest(*this);
    Vec<d> r = a - b;
    for (int k = 0; k < d; ++k) r[k] = nearest(r[k], k);
    return r;
  }

  /// Brings p back inside along the periodic axes, 0 <= p < length, and counts in `image` how often it had gone around:
  /// p + image * lengths stays where it was.
  LICHTENBERG_HOST_DEVICE void wrap(Vec<d>& p, Image<d>& image) const {
    for (int k = 0; k < d; ++k) {
      if (!periodic(k) || (p[k] >= 0 && p[k] < lengths[k])) continue;
      const double turns = std::floor(p[k] / lengths[k]);
      p[k] -= turns * lengths[k];
      image[k] += static_cast<int>(turns);
      // Rounding may leave it a little below 0, or put it on the far side.
      if (p[k] < 0) p[k] = 0;
      if (p[k] >= lengths[k]) p[k] = 0, ++image[k];
    }
  }
};

}  // namespace lichtenberg
