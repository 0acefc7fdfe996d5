#pragma once

#include <cmath>
#include <numbers>

#include "src/model/contact_force.hpp"

namespace lichtenberg {

/// Linear spring and dashpot, F = max(A xi + B xi', 0), xi the overlap (Cundall and Strack 1979), in reduced units. A
/// spring of no geometry: all pairs have the same A and B whatever their radii, so that the restitution of a pair
/// depends on its effective mass (pair_law.hpp).
struct LinearSpringLaw {
  double stiffness = 0;  ///< A
  double damping = 0;    ///< B

  template <class Real>
  LICHTENBERG_HOST_DEVICE Real scale(const Real&, const Real&) const {
    return 1;
  }

  /// Of a pair, or of several at once, at overlaps that are not below 0.
  template <class Real>
  LICHTENBERG_HOST_DEVICE ContactPush<Real> push(const Real& overlap, const Real& scale) const {
    const Real force = scale * stiffness * overlap;
    return {force, scale * damping, 0.5 * force * overlap};
  }
  /// The parts of the force at an overlap; nothing below 0. The force jumps to B closing at touch.
  LICHTENBERG_HOST_DEVICE ContactParts parts(double overlap, double scale = 1) const {
    if (overlap < 0) return {};
    const auto [force, dashpot, stored] = push(overlap, scale);
    return {force, scale * stiffness, stored, dashpot};
  }
  /// How long two grains of mass 1 are in contact, if nothing is lost.
  LICHTENBERG_HOST_DEVICE double shortest_contact(double) const {
    constexpr double effective_mass = 0.5;
    return std::numbers::pi * std::sqrt(effective_mass / stiffness);
  }
  /// About the time in which the dashpot slows two such grains down, which steps must resolve as an elastic contact of
  /// that duration: m_eff / B is its scale. Infinite without damping. The factor is fitted: 16 steps in this time book
  /// what is dissipated to 1e-3.
  LICHTENBERG_HOST_DEVICE double damping_time(double) const {
    constexpr double effective_mass = 0.5, factor = 3.7;
    return damping > 0 ? factor * effective_mass / damping : INFINITY;
  }
  /// The law of a pair whose forces are `by` times as large.
  LICHTENBERG_HOST_DEVICE LinearSpringLaw times(double by) const { return {by * stiffness, by * damping}; }
  LinearSpringLaw undamped(double by) const { return {stiffness * by, 0}; }
  /// B^2/A is all that the restitution depends on.
  LinearSpringLaw stiffer(double by) const { return {stiffness * by, damping * std::sqrt(by)}; }
};

/// acos(z) / sqrt(1 - z^2), and what it goes on as beyond 1.
LICHTENBERG_HOST_DEVICE inline double arc_over_sine(double z) {
  if (z == 1) return 1;
  return z < 1 ? std::acos(z) / std::sqrt((1 - z) * (1 + z)) : std::acosh(z) / std::sqrt((z - 1) * (z + 1));
}

/// Speed after a collision over speed before, and how long the force lasts.
struct LinearCollision {
  double restitution = 0, duration = 0;
};

/// The head-on collision of two grains of effective mass m_eff = m_i m_j / (m_i + m_j), 1/2 for two of mass 1; it does
/// not depend on the speed. With w0^2 = A / m_eff and z = B / (2 m_eff w0) the force is gone after
///   t_c = 2 acos(z) / (w0 sqrt(1 - z^2)) and then  restitution = exp(-z w0 t_c),
/// for z > 1 with acosh(z) / sqrt(z^2 - 1): the contact ends with the force, not with the overlap (Schwager and
/// Poeschel 2007).
LICHTENBERG_HOST_DEVICE inline LinearCollision linear_collision(const LinearSpringLaw& law, double effective_mass) {
  const double frequency = std::sqrt(law.stiffness / effective_mass);
  const double z = law.damping / (2 * effective_mass * frequency), phase = 2 * arc_over_sine(z);
  return {std::exp(-z * phase), phase / frequency};
}

/// The damping B that gives two grains of this effective mass this restitution. Throws InputError unless
/// 0 < restitution <= 1.
double linear_damping(double stiffness, double restitution, double effective_mass);

}  // namespace lichtenberg
