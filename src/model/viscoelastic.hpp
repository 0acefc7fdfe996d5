#pragma once

#include <cmath>

#include "src/model/contact_force.hpp"

namespace lichtenberg {

/// Viscoelastic spheres, F = max(E xi^(3/2) + D sqrt(xi) xi', 0), xi the overlap (Brilliantov, Spahn, Hertzsch and
/// Poeschel 1996), in reduced units. E and D apply to two grains of diameter d0 = 1. For other radii they are
/// multiplied by sqrt(R_eff / (d0/4)), as in Hertz's law (src/effects/hertz.hpp).
struct ViscoelasticLaw {
  static constexpr bool constant_restitution = false;
  double elastic = 0;      ///< E = alpha d0^(5/2) / (m v^2)
  double dissipative = 0;  ///< D = beta d0^(3/2) / (m v)

  /// Returns the factor of E and D for two grains of these radii.
  template <class Real>
  LICHTENBERG_HOST_DEVICE Real scale(const Real& radius_i, const Real& radius_j) const {
    using std::sqrt;
    return 2.0 * sqrt(radius_i * radius_j / (radius_i + radius_j));
  }

  /// Returns the force terms of one pair or of several at overlaps of at least 0.
  template <class Real>
  LICHTENBERG_HOST_DEVICE ContactForceTerms<Real> force_terms(const Real& overlap, const Real& scale) const {
    using std::sqrt;
    const Real root = sqrt(overlap), force = scale * elastic * root * overlap;
    return {force, scale * dissipative * root, 0.4 * force * overlap};
  }
  /// Returns the force terms at an overlap; zero below 0.
  LICHTENBERG_HOST_DEVICE ContactParts parts(double overlap, double scale = 1) const {
    if (!(overlap > 0)) return {};
    const auto [force, dashpot, stored] = force_terms(overlap, scale);
    return {force, 1.5 * force / overlap, stored, dashpot};
  }
  /// Returns the contact duration of two undamped grains of diameter and mass 1 with this impact speed (Hertz).
  LICHTENBERG_HOST_DEVICE double shortest_contact(double speed) const {
    constexpr double effective_mass = 0.5;
    return 3.21806 * std::pow(effective_mass * effective_mass / (elastic * elastic * speed), 0.2);
  }
  /// Returns the time scale in which the dashpot slows two grains of mass 1 down. Steps must resolve it like an elastic
  /// contact of that duration. s'' = -D sqrt(s) s' / m_eff has the scale (m_eff / D)^(2/3) speed^(-1/3). Infinite
  /// without damping. The factor is fitted: 16 steps in this time give the dissipated energy to 1e-3.
  LICHTENBERG_HOST_DEVICE double damping_time(double speed) const {
    constexpr double effective_mass = 0.5, factor = 3.83;
    if (!(dissipative > 0 && speed > 0)) return INFINITY;
    return factor * std::cbrt(effective_mass * effective_mass / (dissipative * dissipative * speed));
  }
  /// Returns the head-on collision, of which only a table or an integration is known: viscoelastic(E, D, m_eff, speed).
  template <class Viscoelastic>
  LICHTENBERG_HOST_DEVICE HeadOnCollision collision(double effective_mass, double scale, double speed,
                                                    const Viscoelastic& viscoelastic) const {
    return viscoelastic(scale * elastic, scale * dissipative, effective_mass, speed);
  }
  /// Returns the law of a pair whose forces are `by` times as large.
  LICHTENBERG_HOST_DEVICE ViscoelasticLaw times(double by) const { return {by * elastic, by * dissipative}; }
  ViscoelasticLaw undamped(double stiffness) const { return {elastic * stiffness, 0}; }
  /// The restitution depends only on k = (D/E) (E/m_eff)^(2/5) v^(1/5).
  ViscoelasticLaw stiffer(double stiffness) const {
    return {elastic * stiffness, dissipative * std::pow(stiffness, 0.6)};
  }
};

}  // namespace lichtenberg
