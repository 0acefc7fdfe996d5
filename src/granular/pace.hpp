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

/// What bounds a step of multirate; reduced units.
struct StepBounds {
  double asked = INFINITY;              ///< mechanics.step; infinite: as the accuracy of forces asks for
  double hold = INFINITY;               ///< longest_hold
  double way = longest_way, speed = 0;  ///< of the fastest grain: how far it may fly, d0, and how fast it does
  double acceleration = 0;              ///< by forces that are held, at most; counts only without `asked`
};

/// The longest within them. `contact_step(gain)`: that of contacts where impacts gain so much speed; forces that are
/// held for less than one gain nothing.
template <class ContactStep>
double longest_step_within(const StepBounds& bounds, const ContactStep& contact_step) {
  const auto& [asked, hold, way, speed, acceleration] = bounds;
  if (std::isinf(asked)) {
    const double flight = time_for(way, speed, acceleration);
    return std::min(hold, std::max(flight, contact_step(2 * acceleration * flight)));
  }
  const double most = std::min(asked, hold);
  return speed * most > way ? way / speed : most;
}

}  // namespace lichtenberg::granular
