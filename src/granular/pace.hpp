#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "solvers/geometry/host_device.hpp"
#include "src/model/grain_contact_law.hpp"

namespace lichtenberg::granular {

/// Largest path of a grain in a step of constant forces, relative to the length over which they change.
constexpr double max_relative_path = 0.2;

/// Returns the speed of the fastest of `grains` Maxwellian grains over sqrt(T/m): the tail sqrt(2/pi) u exp(-u^2/2) of
/// the distribution contains one grain.
inline double fastest_of(std::size_t grains) {
  const double tail = 0.8 * static_cast<double>(std::max<std::size_t>(grains, 2));
  double u = 3;
  for (int k = 0; k < 20; ++k) u = std::sqrt(2 * std::log(tail * std::max(u, 1.0)));
  return u;
}

/// Returns the speed of a typical impact among `grains` Maxwellian grains, relative to an impact of two grains at the
/// speed of the fastest. The rms normal impact speed is 2 sqrt(T/m).
inline double typical_impact(std::size_t grains) { return std::min(1.0, 1 / fastest_of(grains)); }

/// Properties of a gas's grains from which contact substeps are chosen.
struct GrainProperties {
  double lightest = 1, smallest = 0.5;  ///< m0, the mass, and d0, the radius
  double typical = 1;                   ///< typical_impact
};

/// Returns the law that moves two grains of mass 1 and diameter 1 as `law` moves the two lightest grains, whose
/// contacts are the shortest. The factor of the forces is their scale by the radii over the mass. If it is at most 1,
/// the law itself is returned.
template <class Law>
LICHTENBERG_HOST_DEVICE Law for_lightest(const Law& law, const GrainProperties& grains) {
  const double by = law.scale(grains.smallest, grains.smallest) / grains.lightest;
  return by > 1 + 1e-9 ? law.times(by) : law;
}

/// Returns the time (t0) that contact substeps must resolve for impact speeds up to `impact` (v0). It is the duration
/// of the shortest contact, or for strong damping the time in which the dashpot slows typical impacts down. It is
/// divided into mechanics.contact_substeps substeps, or into as many as another integrator needs.
template <class Law>
LICHTENBERG_HOST_DEVICE double time_to_resolve(const Law& law, double impact, const GrainProperties& grains) {
  const Law lightest = for_lightest(law, grains);
  const double contact = lightest.shortest_contact(impact), damping = lightest.damping_time(grains.typical * impact);
  return damping < contact ? damping : contact;
}
inline double time_to_resolve(const GrainContactLaw& law, double impact, const GrainProperties& grains) {
  return std::visit([&](const auto& one) { return time_to_resolve(one, impact, grains); }, law);
}

/// Returns the path (d0) of the fastest of `grains` grains during a step of constant Coulomb forces. With it the error
/// by the step equals a relative rms error `accuracy` of these forces: sqrt(T/m) h = sqrt(accuracy) diameters of the
/// smallest grain (docs/numerics/contact-integration.md).
inline double path_for_accuracy(double accuracy, std::size_t grains, double diameter) {
  return diameter * std::min(max_relative_path, std::sqrt(accuracy) * fastest_of(grains));
}

/// Returns the time in which a grain with this speed and acceleration moves by `path`; infinite if both are 0.
LICHTENBERG_HOST_DEVICE inline double time_for(double path, double speed, double acceleration) {
  return 2 * path / (speed + std::sqrt(speed * speed + 2 * acceleration * path));
}

/// Limits of a step of multirate, in reduced units.
struct StepBounds {
  double requested = INFINITY;                 ///< mechanics.step; infinite: follows from the accuracy of forces
  double stability_limit = INFINITY;           ///< max_outer_step
  double path = max_relative_path, speed = 0;  ///< of the fastest grain: largest path (d0) and speed (v0)
  double acceleration = 0;                     ///< largest by slow forces; used without `requested` only
};

/// Returns the longest step within the limits. `contact_step(gain)` is the contact substep for impacts that are faster
/// by `gain`; shorter steps gain no accuracy.
template <class ContactStep>
LICHTENBERG_HOST_DEVICE double longest_step_within(const StepBounds& bounds, const ContactStep& contact_step) {
  const auto& [requested, stability_limit, path, speed, acceleration] = bounds;
  if (std::isinf(requested)) {
    const double flight = time_for(path, speed, acceleration);
    return std::min(stability_limit, std::max(flight, contact_step(2 * acceleration * flight)));
  }
  const double most = std::min(requested, stability_limit);
  return speed * most > path ? path / speed : most;
}

/// Returns the longest step (t0) of constant forces (multirate) for two grains of this effective mass with this largest
/// attraction. It is a quarter of the period of their oscillation about the equilibrium overlap; infinite without an
/// attraction.
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
