#pragma once

#include <cmath>

#include "src/model/contact_force.hpp"

namespace lichtenberg {

/// Contact law of viscoelastic spheres (damped Hertz contact, Kuwabara-Kono), force F = max(E xi^(3/2) + D sqrt(xi)
/// dxi/dt, 0) with overlap xi (Brilliantov and others 1996), in reduced units. E and D are those of two grains of
/// diameter d0 = 1. For other radii they are multiplied by sqrt(R_eff / (d0/4)), as in Hertz's law
/// (src/effects/hertz.hpp).
struct ViscoelasticLaw {
  static constexpr bool constant_restitution = false;
  double elastic = 0;      ///< E = alpha d0^(5/2) / (m0 v0^2), for a force alpha xi^(3/2) in SI
  double dissipative = 0;  ///< D = beta d0^(3/2) / (m0 v0), for a force beta sqrt(xi) dxi/dt in SI

  /// Returns the factor sqrt(R_eff / (d0/4)) of E and D for two grains of these radii, R_eff = R_i R_j / (R_i + R_j).
  template <class Real>
  LICHTENBERG_HOST_DEVICE Real scale(const Real& radius_i, const Real& radius_j) const {
    using std::sqrt;
    return 2.0 * sqrt(radius_i * radius_j / (radius_i + radius_j));
  }

  /// Returns elastic force, damping coefficient and elastic energy at an overlap of at least 0, times `scale`. `Real`
  /// is a double for one pair, or a SIMD vector for several pairs.
  template <class Real>
  LICHTENBERG_HOST_DEVICE ContactForceTerms<Real> force_terms(const Real& overlap, const Real& scale) const {
    using std::sqrt;
    const Real root = sqrt(overlap), force = scale * elastic * root * overlap;
    return {force, scale * dissipative * root, 0.4 * force * overlap};
  }
  /// Returns elastic force, its slope, elastic energy and damping coefficient at an overlap, times `scale`; zero unless
  /// the overlap is positive.
  LICHTENBERG_HOST_DEVICE ContactParts parts(double overlap, double scale = 1) const {
    if (!(overlap > 0)) return {};
    const auto [force, dashpot, stored] = force_terms(overlap, scale);
    return {force, 1.5 * force / overlap, stored, dashpot};
  }
  /// Returns the contact duration of two undamped grains of diameter and mass 1 at an impact speed (Hertz).
  LICHTENBERG_HOST_DEVICE double shortest_contact(double speed) const {
    constexpr double effective_mass = 0.5;
    return 3.21806 * std::pow(effective_mass * effective_mass / (elastic * elastic * speed), 0.2);
  }
  /// Returns the time scale in which the dissipative force slows two grains of mass 1 down, proportional to (m_eff /
  /// D)^(2/3) speed^(-1/3); infinite without damping. Time steps must resolve it like an elastic contact of this
  /// duration. The factor is fitted: 16 steps in this time give the dissipated energy with a relative error of at most
  /// 1e-3 (tests/granular_contact_steps_test.cpp).
  LICHTENBERG_HOST_DEVICE double damping_time(double speed) const {
    constexpr double effective_mass = 0.5, factor = 3.83;
    if (!(dissipative > 0 && speed > 0)) return INFINITY;
    return factor * std::cbrt(effective_mass * effective_mass / (dissipative * dissipative * speed));
  }
  /// Returns restitution coefficient and duration of a head-on collision at an impact speed. No closed form exists, so
  /// the caller's function viscoelastic(E, D, m_eff, speed) computes them from a table or by integration.
  template <class Viscoelastic>
  LICHTENBERG_HOST_DEVICE HeadOnCollision collision(double effective_mass, double scale, double speed,
                                                    const Viscoelastic& viscoelastic) const {
    return viscoelastic(scale * elastic, scale * dissipative, effective_mass, speed);
  }
  /// Returns the law with all forces multiplied by `by`.
  LICHTENBERG_HOST_DEVICE ViscoelasticLaw times(double by) const { return {by * elastic, by * dissipative}; }
  /// Returns the law without damping and with the elastic coefficient E multiplied by `stiffness`.
  ViscoelasticLaw undamped(double stiffness) const { return {elastic * stiffness, 0}; }
  /// Returns the law with E multiplied by `stiffness` and D by stiffness^(3/5). The restitution coefficient is
  /// unchanged, since it depends only on (D/E) (E/m_eff)^(2/5) v^(1/5), v the impact speed.
  ViscoelasticLaw stiffer(double stiffness) const {
    return {elastic * stiffness, dissipative * std::pow(stiffness, 0.6)};
  }
};

}  // namespace lichtenberg
