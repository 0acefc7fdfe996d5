#pragma once

#include "solvers/geometry/host_device.hpp"

namespace lichtenberg {

/// A damped contact of two grains at one instant, in reduced units (m = d0 = v = 1: pure numbers).
struct ContactForce {
  double force = 0;       ///< repulsive, at least 0
  double dissipated = 0;  ///< power, at least 0
};

/// Terms of the force elastic(overlap) + damping(overlap) * closing speed that time integration of a contact needs.
/// `Real` holds one pair or several.
template <class Real>
struct ContactForceTerms {
  Real elastic{}, damping{}, stored{};
};

/// All terms of a contact's force.
struct ContactParts {
  double elastic = 0, elastic_slope = 0, stored = 0;
  double damping = 0;
};

/// Head-on collision of two grains on which only their contact force acts.
struct HeadOnCollision {
  double restitution = 0;  ///< speed after over speed before
  double duration = 0;     ///< t0, of the force; 0 if it was not computed
};

/// Returns the force max(elastic + damping * closing, 0), where `closing` is the closing speed. Grains without adhesion
/// never attract, so a contact that opens fast ends before its overlap is zero. The elastic energy left then is
/// dissipated as well. The power (force - elastic) * closing is damping * closing^2 while the force acts, and
/// -elastic * closing while it does not.
LICHTENBERG_HOST_DEVICE inline ContactForce contact_force(const ContactParts& parts, double closing) {
  const double force = parts.elastic + parts.damping * closing;
  if (force <= 0) return {0, -parts.elastic * closing};
  return {force, parts.damping * closing * closing};
}

/// Returns the contact force of one pair at an overlap; zero if the two do not overlap.
template <class Law>
LICHTENBERG_HOST_DEVICE ContactForce contact_at(const Law& law, double overlap, double closing, double scale = 1) {
  return overlap <= 0 ? ContactForce{} : contact_force(law.parts(overlap, scale), closing);
}

}  // namespace lichtenberg
