#pragma once

#include <cmath>

namespace lichtenberg::effects {

/// E* of two bodies of like material (Pa; Hertz 1882): 1/E* = 2 (1 - poisson^2) / young.
inline double contact_modulus(double young, double poisson) { return young / (2 * (1 - poisson * poisson)); }

struct HertzForce {
  double force = 0;      ///< N, repulsive
  double stiffness = 0;  ///< N/m, d force / d overlap
  double energy = 0;     ///< J, integral of the force: 2/5 force overlap
};

/// F = 4/3 E* sqrt(R_eff) overlap^(3/2) (D 5.9, whose overlap is misprinted); overlap > 0 and 1/R_eff, the sum of both
/// surfaces' curvatures, in metres.
inline HertzForce hertz(double modulus, double effective_radius, double overlap) {
  const double stiffness = 2 * modulus * std::sqrt(effective_radius * overlap);
  const double force = 2.0 / 3.0 * stiffness * overlap;
  return {force, stiffness, 0.4 * force * overlap};
}

}  // namespace lichtenberg::effects
