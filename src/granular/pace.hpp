#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "solvers/geometry/host_device.hpp"
#include "src/model/grain_contact_law.hpp"

namespace lichtenberg::granular {

/// Largest path of a grain in a step of constant forces, relative to the length over which the forces change.
constexpr double max_relative_path = 0.2;

/// Path (d0) of the fastest grain between two searches for candidate pairs. A longer path makes the lists longer.
constexpr double path_per_search = 0.3;

/// Returns the expected largest speed u among n = `grains` grains with a Maxwell distribution, in units of sqrt(T/m).
/// The tail of the distribution beyond u, about sqrt(2/pi) u exp(-u^2/2), contains one grain.
inline double fastest_of(std::size_t grains) {
  const double tail = 0.8 * static_cast<double>(std::max<std::size_t>(grains, 2));
  double u = 3;
  for (int k = 0; k < 20; ++k) u = std::sqrt(2 * std::log(tail * std::max(u, 1.0)));
  return u;
}

/// Returns the ratio of a typical to the largest impact speed among `grains` grains with a Maxwell distribution. The
/// typical speed is the rms normal impact speed 2 sqrt(T/m); the largest is twice the speed of the fastest grain.
inline double typical_impact(std::size_t grains) { return std::min(1.0, 1 / fastest_of(grains)); }

/// Properties of the grains of a gas from which the length of contact substeps is chosen.
struct GrainProperties {
  double lightest = 1, smallest = 0.5;  ///< smallest mass (m0) and smallest radius (d0)
  double typical = 1;                   ///< typical_impact(): typical over largest impact speed
};

/// Returns the contact law for which two grains of mass 1 and diameter 1 move like the two lightest grains with `law`.
/// Contacts of the lightest grains are the shortest. The factor of the forces is law.scale() for the smallest radius,
/// over the smallest mass. If it is at most 1, `law` itself is returned.
template <class Law>
LICHTENBERG_HOST_DEVICE Law for_lightest(const Law& law, const GrainProperties& grains) {
  const double by = law.scale(grains.smallest, grains.smallest) / grains.lightest;
  return by > 1 + 1e-9 ? law.times(by) : law;
}

/// Returns the time (t0) that contact substeps must resolve for impact speeds up to `impact` (v0). It is the shortest
/// contact duration, or the damping time of typical impacts if it is shorter. Multirate divides it into
/// mechanics.contact_substeps substeps.
template <class Law>
LICHTENBERG_HOST_DEVICE double time_to_resolve(const Law& law, double impact, const GrainProperties& grains) {
  const Law lightest = for_lightest(law, grains);
  const double contact = lightest.shortest_contact(impact), damping = lightest.damping_time(grains.typical * impact);
  return damping < contact ? damping : contact;
}
/// Returns the time (t0) that contact substeps must resolve for impact speeds up to `impact` (v0), for any contact law.
inline double time_to_resolve(const GrainContactLaw& law, double impact, const GrainProperties& grains) {
  return std::visit([&](const auto& one) { return time_to_resolve(one, impact, grains); }, law);
}

/// Returns the path (d0) of the fastest of `grains` grains in a step h of constant Coulomb forces. The step follows
/// from sqrt(T/m) h = sqrt(accuracy) * diameter. The error of this step is then about that of a relative rms error
/// `accuracy` of the forces (docs/numerics/contact-integration.md). The path is at most max_relative_path * diameter.
/// `diameter`: smallest diameter, or a shorter length over which forces change (d0).
inline double path_for_accuracy(double accuracy, std::size_t grains, double diameter) {
  return diameter * std::min(max_relative_path, std::sqrt(accuracy) * fastest_of(grains));
}

/// Returns the time in which a grain with this initial speed and constant acceleration along it moves by `path`, in
/// reduced units; infinite if both are 0.
LICHTENBERG_HOST_DEVICE inline double time_for(double path, double speed, double acceleration) {
  return 2 * path / (speed + std::sqrt(speed * speed + 2 * acceleration * path));
}

/// Limits of the outer step (from one evaluation of the smooth forces to the next) of multiple time stepping
/// (multirate), in reduced units.
struct StepBounds {
  double requested = INFINITY;                 ///< mechanics.step; infinite: the step follows from `path`
  double stability_limit = INFINITY;           ///< max_outer_step(): quarter period of a bound pair
  double path = max_relative_path, speed = 0;  ///< of the fastest grain: largest path (d0) and speed (v0)
  double acceleration = 0;                     ///< largest by slow forces; used only if `requested` is infinite
};

/// Returns the longest outer step (t0) within the limits. An outer step lasts from one evaluation of the smooth forces
/// to the next. contact_step(gain) is the contact substep (t0) if impact speeds increase by `gain` (v0). Without a
/// requested step, the outer step is at least one contact substep, because a shorter one gains no accuracy; only the
/// stability limit can shorten it further.
template <class ContactStep>
LICHTENBERG_HOST_DEVICE double longest_step_within(const StepBounds& bounds, const ContactStep& contact_step) {
  const auto& [requested, stability_limit, path, speed, acceleration] = bounds;
  if (std::isinf(requested)) {
    const double flight = time_for(path, speed, acceleration);
    if (std::isinf(flight)) return stability_limit;  // no motion
    return std::min(stability_limit, std::max(flight, contact_step(2 * acceleration * flight)));
  }
  const double most = std::min(requested, stability_limit);
  return speed * most > path ? path / speed : most;
}

/// Returns a limit of the outer step (t0), over which forces except contacts are constant (multirate), that keeps the
/// oscillation of bound pairs stable. It is a quarter of the period of two grains about their equilibrium overlap;
/// infinite without an attraction. `attraction`: largest attractive force in contact; `effective_mass`: m_i m_j / (m_i
/// + m_j), in reduced units.
template <class Law>
LICHTENBERG_HOST_DEVICE double max_outer_step(const Law& law, double attraction, double effective_mass) {
  if (!(attraction > 0)) return INFINITY;
  double low = 0, high = 1;
  for (int k = 0; k < 50; ++k) {
    const double middle = 0.5 * (low + high);
    (law.parts(middle).elastic < attraction ? low : high) = middle;
  }
  return 0.25 * 2 * std::numbers::pi * std::sqrt(effective_mass / law.parts(high).elastic_slope);
}

}  // namespace lichtenberg::granular
