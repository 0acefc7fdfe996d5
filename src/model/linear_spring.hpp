#pragma once

#include <cmath>
#include <numbers>

#include "src/model/contact_force.hpp"

namespace lichtenberg {

/// Returns acos(z) / sqrt(1 - z^2), and its analytic continuation for z > 1.
LICHTENBERG_HOST_DEVICE inline double arc_over_sine(double z) {
  if (z == 1) return 1;
  return z < 1 ? std::acos(z) / std::sqrt((1 - z) * (1 + z)) : std::acosh(z) / std::sqrt((z - 1) * (z + 1));
}

/// Contact law of a linear spring and dashpot, force F = max(A xi + B dxi/dt, 0) with overlap xi (Cundall and Strack
/// 1979), in reduced units. All pairs have the same A and B whatever their radii. The restitution coefficient of a pair
/// therefore depends on its effective mass (if B > 0), but not on the impact speed.
struct LinearSpringLaw {
  static constexpr bool constant_restitution = true;
  double stiffness = 0;  ///< A
  double damping = 0;    ///< B

  /// Returns the factor of the forces for two radii: always 1.
  template <class Real>
  LICHTENBERG_HOST_DEVICE Real scale(const Real&, const Real&) const {
    return 1;
  }

  /// Returns elastic force, damping coefficient and elastic energy at an overlap of at least 0, times `scale`. `Real`
  /// is a double for one pair, or a SIMD vector for several pairs.
  template <class Real>
  LICHTENBERG_HOST_DEVICE ContactForceTerms<Real> force_terms(const Real& overlap, const Real& scale) const {
    const Real force = scale * stiffness * overlap;
    return {force, scale * damping, 0.5 * force * overlap};
  }
  /// Returns elastic force, its slope, elastic energy and damping coefficient at an overlap, times `scale`; zero for a
  /// negative overlap. At onset the force jumps from 0 to B times the closing speed.
  LICHTENBERG_HOST_DEVICE ContactParts parts(double overlap, double scale = 1) const {
    if (overlap < 0) return {};
    const auto [force, dashpot, stored] = force_terms(overlap, scale);
    return {force, scale * stiffness, stored, dashpot};
  }
  /// Returns the contact duration of two grains of mass 1 without damping, pi sqrt(m_eff / A), at any impact speed.
  LICHTENBERG_HOST_DEVICE double shortest_contact(double) const {
    constexpr double effective_mass = 0.5;
    return std::numbers::pi * std::sqrt(effective_mass / stiffness);
  }
  /// Returns the time scale in which the dashpot slows two grains of mass 1 down, proportional to m_eff / B; infinite
  /// without damping. Time steps must resolve it like an elastic contact of this duration. The factor is fitted: 16
  /// steps in this time give the dissipated energy with a relative error of about 1e-3.
  LICHTENBERG_HOST_DEVICE double damping_time(double) const {
    constexpr double effective_mass = 0.5, factor = 3.7;
    return damping > 0 ? factor * effective_mass / damping : INFINITY;
  }
  /// Returns restitution coefficient and duration of a head-on collision of two grains of effective mass m_eff = m_i
  /// m_j / (m_i + m_j), at any speed. With w0^2 = A / m_eff and z = B / (2 m_eff w0), the force ends after
  ///
  ///   t_c = 2 acos(z) / (w0 sqrt(1 - z^2)), and  restitution = exp(-z w0 t_c).
  ///
  /// For z > 1, acosh(z) / sqrt(z^2 - 1) replaces acos(z) / sqrt(1 - z^2). The contact ends when the force vanishes,
  /// not when the overlap does (Schwager and Poeschel 2007).
  LICHTENBERG_HOST_DEVICE HeadOnCollision collision(double effective_mass) const {
    const double frequency = std::sqrt(stiffness / effective_mass);
    const double z = damping / (2 * effective_mass * frequency), phase = 2 * arc_over_sine(z);
    return {std::exp(-z * phase), phase / frequency};
  }
  /// Returns collision(effective_mass), for the interface of contact laws. Scale, speed and viscoelastic solver have no
  /// effect.
  template <class Viscoelastic>
  LICHTENBERG_HOST_DEVICE HeadOnCollision collision(double effective_mass, double, double, const Viscoelastic&) const {
    return collision(effective_mass);
  }
  /// Returns the law with all forces multiplied by `by`.
  LICHTENBERG_HOST_DEVICE LinearSpringLaw times(double by) const { return {by * stiffness, by * damping}; }
  /// Returns the law without damping (B = 0) and with the stiffness A multiplied by `by`.
  LinearSpringLaw undamped(double by) const { return {stiffness * by, 0}; }
  /// Returns the law with the stiffness A multiplied by `by` and the damping B by sqrt(by). The restitution
  /// coefficient, which depends only on B^2/A and the effective mass, is unchanged.
  LinearSpringLaw stiffer(double by) const { return {stiffness * by, damping * std::sqrt(by)}; }
};

/// Returns the damping B of LinearSpringLaw for which two grains of this effective mass have this restitution
/// coefficient. `stiffness` is A. Throws InputError unless 0 < restitution <= 1.
double linear_damping(double stiffness, double restitution, double effective_mass);

}  // namespace lichtenberg
