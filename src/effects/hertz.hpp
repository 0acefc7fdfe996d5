#pragma once

#include <cmath>

#include "src/model/pair_law.hpp"

namespace lichtenberg::effects {

/// Elastic constants of a material: Young's modulus (Pa) and Poisson's ratio.
struct Elasticity {
  double young = 0;  ///< Pa
  double poisson = 0;

  double plane_modulus() const { return young / (1 - poisson * poisson); }  ///< plane-strain modulus (Pa)
};

/// Returns the contact modulus E* of two materials (Pa; Hertz 1882): 1/E* = (1 - poisson_a^2) / young_a + (1 -
/// poisson_b^2) / young_b.
inline double contact_modulus(const Elasticity& a, const Elasticity& b) {
  return a.plane_modulus() / (1 + a.plane_modulus() / b.plane_modulus());
}

/// Hertz's contact force at one overlap, with its derivative and energy.
struct HertzForce {
  double force = 0;      ///< repulsive force (N)
  double stiffness = 0;  ///< derivative of the force by the overlap (N/m)
  double energy = 0;     ///< elastic energy (J): 2/5 force overlap
};

/// Returns Hertz's contact force F = 4/3 E* sqrt(R_eff) overlap^(3/2), its stiffness and energy (Hertz 1882).
/// `modulus`: contact modulus E* (Pa); `effective_radius`: R_eff (m), 1/R_eff the sum of the curvatures of both
/// surfaces; `overlap`: m, at least 0.
LICHTENBERG_HOST_DEVICE inline HertzForce hertz(double modulus, double effective_radius, double overlap) {
  const double stiffness = 2 * modulus * std::sqrt(effective_radius * overlap);
  const double force = 2.0 / 3.0 * stiffness * overlap;
  return {force, stiffness, 0.4 * force * overlap};
}

/// Pair force law of Hertz's elastic contact between two spheres. The functions are those that pair_law.hpp requires.
struct HertzLaw {
  static constexpr bool over_distance = false, charged = false;
  double modulus = 0;  ///< contact modulus E* (Pa)

  LICHTENBERG_HOST_DEVICE double reach(double radius_i, double radius_j) const { return radius_i + radius_j; }
  LICHTENBERG_HOST_DEVICE double energy_unit() const { return 1; }
  LICHTENBERG_HOST_DEVICE double overlap(const PairGeometry& pair) const {
    return pair.distance < pair.reach ? pair.reach - pair.distance : 0;  // rounding can give a distance beyond reach
  }
  LICHTENBERG_HOST_DEVICE PairForce operator()(const PairGeometry& pair) const {
    const HertzForce law = hertz(modulus, 1 / (1 / pair.radius_i + 1 / pair.radius_j), overlap(pair));
    return {law.energy, law.force, law.stiffness};
  }
  /// Returns true if the overlap exceeds the smaller radius, so that the law is not valid. Hertz's law holds for
  /// overlaps much smaller than the spheres.
  LICHTENBERG_HOST_DEVICE bool refuses(const PairGeometry& pair) const {
    return overlap(pair) > (pair.radius_i < pair.radius_j ? pair.radius_i : pair.radius_j);
  }
};

}  // namespace lichtenberg::effects
