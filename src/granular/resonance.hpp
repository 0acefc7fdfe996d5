#pragma once

#include <cmath>
#include <numbers>

#include "solvers/geometry/host_device.hpp"

namespace lichtenberg::granular {

/// How long forces may be held (multirate) where two grains of this effective mass attract each other with this force
/// at most: a quarter of the period in which they swing about the overlap that bears it. Infinite without an
/// attraction.
template <class Law>
LICHTENBERG_HOST_DEVICE double longest_hold(const Law& law, double attraction, double effective_mass) {
  if (!(attraction > 0)) return INFINITY;
  double low = 0, high = 1;
  for (int k = 0; k < 50; ++k) {
    const double middle = 0.5 * (low + high);
    (law.parts(middle).elastic < attraction ? low : high) = middle;
  }
  return 0.25 * 2 * std::numbers::pi * std::sqrt(effective_mass / law.parts(high).elastic_slope);
}

}  // namespace lichtenberg::granular
