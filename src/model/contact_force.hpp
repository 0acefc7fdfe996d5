#pragma once

#include "solvers/geometry/host_device.hpp"

namespace lichtenberg {

/// A damped contact of two grains at one instant, in reduced units (m = d0 = v = 1: pure numbers).
struct ContactForce {
  double force = 0;       ///< repulsive, never below 0
  double stored = 0;      ///< elastic energy
  double dissipated = 0;  ///< power, never below 0
};

/// The parts of a force elastic(overlap) + damping(overlap) closing that who follows a contact needs, of one pair or of
/// several at once.
template <class Real>
struct ContactPush {
  Real elastic{}, damping{}, stored{};
};

/// All its parts.
struct ContactParts {
  double elastic = 0, elastic_slope = 0, stored = 0;
  double damping = 0;
};

/// The force max(elastic + damping closing, 0): grains that do not stick never pull, so a contact that opens fast gives
/// way before the overlap is gone. What the spring has left then is lost as well: the power
/// (force - elastic) closing is damping closing^2 while the force acts and -elastic closing while it does not.
LICHTENBERG_HOST_DEVICE inline ContactForce contact_force(const ContactParts& parts, double closing) {
  const double force = parts.elastic + parts.damping * closing;
  if (force <= 0) return {.stored = parts.stored, .dissipated = -parts.elastic * closing};
  return {force, parts.stored, parts.damping * closing * closing};
}

/// The contact of one pair, for code that follows its overlap; nothing if the two do not overlap.
template <class Law>
LICHTENBERG_HOST_DEVICE ContactForce contact_at(const Law& law, double overlap, double closing, double scale = 1) {
  return overlap <= 0 ? ContactForce{} : contact_force(law.parts(overlap, scale), closing);
}

}  // namespace lichtenberg
