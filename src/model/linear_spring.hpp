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

/// Linear spring and dashpot, F = max(A xi + B xi', 0), xi the overlap (Cundall and Strack 1979), in reduced units. All
/// pairs have the same A and B whatever their radii, so the restitution of a pair depends on its effective mass.
struct LinearSpringLaw {
  static constexpr bool constant_restitution = true;
  double stiffness = 0;  ///< A
  double damping = 0;    ///< B

  template <class Real>
  LICHTENBERG_HOST_DEVICE Real scale(const Real&, const Real&) const {
    return 1;
  }

  /// Returns the force terms of one pair or of several at overlaps of at least 0.
  template <class Real>
  LICHTENBERG_HOST_DEVICE ContactForceTerms<Real> force_terms(const Real& overlap, const Real& scale) const {
    const Real force = scale * stiffness * overlap;
    return {force, scale * damping, 0.5 * force * overlap};
  }
  /// Returns the force terms at an overlap; zero below 0. At onset the force jumps to B closing.
  LICHTENBERG_HOST_DEVICE ContactParts parts(double overlap, double scale = 1) const {
    if (overlap < 0) return {};
    const auto [force, dashpot, stored] = force_terms(overlap, scale);
    return {force, scale * stiffness, stored, dashpot};
  }
  /// Returns the contact duration of two grains of mass 1 without damping.
  LICHTENBERG_HOST_DEVICE double shortest_contact(double) const {
    constexpr double effective_mass = 0.5;
    return std::numbers::pi * std::sqrt(effective_mass / stiffness);
  }
  /// Returns the time scale in which the dashpot slows two grains of mass 1 down, proportional to m_eff / B. Steps must
  /// resolve it like an elastic contact of that duration. Infinite without damping. The factor is fitted: 16 steps in
  /// this time give the dissipated energy to 1e-3.
  LICHTENBERG_HOST_DEVICE double damping_time(double) const {
    constexpr double effective_mass = 0.5, factor = 3.7;
    return damping > 0 ? factor * effective_mass / damping : INFINITY;
  }
  /// Returns the head-on collision of two grains of effective mass m_eff = m_i m_j / (m_i + m_j), 1/2 for two of mass
  /// 1. It does not depend on the speed. With w0^2 = A / m_eff and z = B / (2 m_eff w0), the force ends after
  ///
  ///   t_c = 2 acos(z) / (w0 sqrt(1 - z^2)), and  restitution = exp(-z w0 t_c).
  ///
  /// For z > 1, acosh(z) / sqrt(z^2 - 1) replaces the arc. The contact ends with the force, not with the overlap
  /// (Schwager and Poeschel 2007).
  LICHTENBERG_HOST_DEVICE HeadOnCollision collision(double effective_mass) const {
    const double frequency = std::sqrt(stiffness / effective_mass);
    const double z = damping / (2 * effective_mass * frequency), phase = 2 * arc_over_sine(z);
    return {std::exp(-z * phase), phase / frequency};
  }
  template <class Viscoelastic>
  LICHTENBERG_HOST_DEVICE HeadOnCollision collision(double effective_mass, double, double, const Viscoelastic&) const {
    return collision(effective_mass);
  }
  /// Returns the law of a pair whose forces are `by` times as large.
  LICHTENBERG_HOST_DEVICE LinearSpringLaw times(double by) const { return {by * stiffness, by * damping}; }
  LinearSpringLaw undamped(double by) const { return {stiffness * by, 0}; }
  /// The restitution depends only on B^2/A.
  LinearSpringLaw stiffer(double by) const { return {stiffness * by, damping * std::sqrt(by)}; }
};

/// Returns the damping B that gives two grains of this effective mass this restitution. Throws InputError unless 0 <
/// restitution <= 1.
double linear_damping(double stiffness, double restitution, double effective_mass);

}  // namespace lichtenberg
