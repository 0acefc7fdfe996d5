#pragma once

#include "solvers/geometry/host_device.hpp"

namespace lichtenberg {

/// Normal contact force of two grains at one instant, and the power that it dissipates. Units are reduced: mass m0,
/// diameter d0 and speed v0 of reference are 1.
struct ContactForce {
  double force = 0;       ///< m0 v0^2/d0, repulsive, at least 0
  double dissipated = 0;  ///< m0 v0^3/d0, dissipated power, at least 0
};

/// Terms of the damped contact force elastic + damping * (closing speed) of two grains at an overlap, in reduced units.
/// `Real` is a double for one pair, or a SIMD vector for several pairs.
template <class Real>
struct ContactForceTerms {
  /// Elastic force; damping coefficient, the dissipative force over the closing speed; elastic energy.
  Real elastic{}, damping{}, stored{};
};

/// Terms of the damped contact force elastic + damping * (closing speed) of two grains at an overlap, in reduced units.
/// In addition to ContactForceTerms it has the derivative of the elastic force.
struct ContactParts {
  /// Elastic force, its derivative by the overlap, and the elastic energy.
  double elastic = 0, elastic_slope = 0, stored = 0;
  /// Damping coefficient: dissipative force over closing speed.
  double damping = 0;
};

/// Result of a head-on collision of two grains on which only their contact force acts.
struct HeadOnCollision {
  double restitution = 0;  ///< restitution coefficient, speed after over speed before
  double duration = 0;     ///< duration of the contact force (t0, reduced unit of time); 0 if it was not computed
};

/// Returns the contact force max(elastic + damping * closing, 0) and the dissipated power; `closing` is the closing
/// speed. The grains have no adhesion, so the contact force is never attractive. In a contact that opens fast, the
/// force ends before the overlap is zero, and the remaining elastic energy is dissipated. The power (force - elastic) *
/// closing is damping * closing^2 while the force acts, and -elastic * closing while the force is zero.
LICHTENBERG_HOST_DEVICE inline ContactForce contact_force(const ContactParts& parts, double closing) {
  const double force = parts.elastic + parts.damping * closing;
  if (force <= 0) return {0, -parts.elastic * closing};
  return {force, parts.damping * closing * closing};
}

/// Returns the contact force and dissipated power of two grains at an overlap and closing speed, in reduced units; zero
/// if they do not overlap. `scale`: the law's factor of the forces for the radii of the pair.
template <class Law>
LICHTENBERG_HOST_DEVICE ContactForce contact_at(const Law& law, double overlap, double closing, double scale = 1) {
  return overlap <= 0 ? ContactForce{} : contact_force(law.parts(overlap, scale), closing);
}

}  // namespace lichtenberg
