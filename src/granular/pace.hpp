#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "solvers/geometry/host_device.hpp"
#include "src/model/grain_contact_law.hpp"

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

/// The speed of a typical impact in a gas of so many Maxwellian grains, over the largest that there could be, of two at
/// the speed of the fastest: rms normal speeds of impact are 2 sqrt(T/m).
inline double typical_impact(std::size_t grains) { return std::min(1.0, 1 / fastest_of(grains)); }

/// Properties of a gas's grains from which the steps of contacts are chosen.
struct GrainsSeen {
  double lightest = 1, smallest = 0.5;  ///< m0, the mass, and d0, the radius
  double typical = 1;                   ///< typical_impact
};

/// The law that moves two grains of mass 1 and diameter 1 as `law` moves the two lightest, whose contacts are the
/// shortest: forces over mass. Of grains that are no lighter than that the law itself.
template <class Law>
LICHTENBERG_HOST_DEVICE Law for_lightest(const Law& law, const GrainsSeen& grains) {
  const double by = law.scale(grains.smallest, grains.smallest) / grains.lightest;
  return by > 1 + 1e-9 ? law.times(by) : law;
}

/// The time that steps of contacts must resolve (mechanics.contact_steps of them, or as many as another integrator
/// needs) where two grains meet at the speed `impact` at most: how long the shortest contact lasts, or how fast the
/// dashpot slows typical impacts down, where damping is strong.
template <class Law>
LICHTENBERG_HOST_DEVICE double time_to_resolve(const Law& law, double impact, const GrainsSeen& grains) {
  const Law lightest = for_lightest(law, grains);
  const double contact = lightest.shortest_contact(impact), damping = lightest.damping_time(grains.typical * impact);
  return damping < contact ? damping : contact;
}
inline double time_to_resolve(const GrainContactLaw& law, double impact, const GrainsSeen& grains) {
  return std::visit([&](const auto& one) { return time_to_resolve(one, impact, grains); }, law);
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
LICHTENBERG_HOST_DEVICE double longest_step_within(const StepBounds& bounds, const ContactStep& contact_step) {
  const auto& [asked, hold, way, speed, acceleration] = bounds;
  if (std::isinf(asked)) {
    const double flight = time_for(way, speed, acceleration);
    return std::min(hold, std::max(flight, contact_step(2 * acceleration * flight)));
  }
  const double most = std::min(asked, hold);
  return speed * most > way ? way / speed : most;
}

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
