#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "solvers/geometry/host_device.hpp"

namespace lichtenberg::granular {

/// The way, in diameters, farther than which no grain flies while forces are held: they change over a diameter.
constexpr double longest_way = 0.2;

/// Speed of the fastest of so many Maxwellian grains over sqrt(T/m): the tail sqrt(2/pi) u exp(-u^2/2) holds one of
/// them.
inline double fastest_of(std::size_t grains) {
  const double tail = 0.8 * static_cast<double>(std::max<std::size_t>(grains, 2));
  double u = 3;
  for (int k = 0; k < 20; ++k) u = std::sqrt(2 * std::log(tail * std::max(u, 1.0)));
  return u;
}

/// The way that the fastest of so many grains may fly while forces of charges are held, such that it costs what an
/// error `accuracy` of these forces (rms over rms) does: sqrt(T/m) h = sqrt(accuracy) diameters, of the smallest
/// (README, how long forces are held).
inline double way_for(double accuracy, std::size_t grains, double diameter) {
  return diameter * std::min(longest_way, std::sqrt(accuracy) * fastest_of(grains));
}

/// The time in which speed and acceleration lead no farther than `way`; infinite if there are none.
LICHTENBERG_HOST_DEVICE inline double time_for(double way, double speed, double acceleration) {
  return 2 * way / (speed + std::sqrt(speed * speed + 2 * acceleration * way));
}

}  // namespace lichtenberg::granular
