#pragma once

#include <cmath>

#include "src/model/pair_law.hpp"

namespace lichtenberg::effects {

/// w(q) = (q - 1) ln q and its derivatives with respect to q, for 0 < q <= 1. w(1) = w'(1) = 0 and w''(1) = 2, so the
/// second derivative jumps to 0 where contact ends. w diverges for q -> 0: w ~ -ln q, w' ~ -1/q.
struct ContactLaw {
  double energy = 0, slope = 0, curvature = 0;
};

/// Lower bound of q for full accuracy of `logarithm_near_one`; the upper bound is 1.
constexpr double near_one = 0.8;

/// Returns ln q = 2 artanh(s) with s = (q - 1) / (q + 1) (Abramowitz & Stegun 4.1.27). For |s| <= 1/9 the first omitted
/// term, s^17 / 17, is below the rounding of s. The absence of branches allows vectorization. q - 1 is exact and keeps
/// all its digits, which matter because w is quadratic in it just inside contact.
LICHTENBERG_HOST_DEVICE inline double logarithm_of_ratio(double s) {
  const double t = s * s;
  double sum = 1.0 / 15;
  for (int n = 13; n > 0; n -= 2) sum = sum * t + 1.0 / n;
  return 2 * s * sum;
}
LICHTENBERG_HOST_DEVICE inline double logarithm_near_one(double q) { return logarithm_of_ratio((q - 1) / (q + 1)); }

/// Returns the law at q for a given logarithm of q.
LICHTENBERG_HOST_DEVICE inline ContactLaw contact_law(double q, double logarithm) {
  const double excess = q - 1;
  return {excess * logarithm, logarithm + excess / q, (q + 1) / (q * q)};
}

LICHTENBERG_HOST_DEVICE inline ContactLaw contact_law(double q) {
  return contact_law(q, q >= near_one ? logarithm_near_one(q) : std::log(q));
}

/// Pair law U = stiffness w(q), where q is the distance over the sum of the radii (pair_law.hpp).
struct ContactPotentialLaw {
  static constexpr bool over_distance = true;
  double stiffness = 1;  ///< J

  LICHTENBERG_HOST_DEVICE double reach(double radius_i, double radius_j) const { return radius_i + radius_j; }
  LICHTENBERG_HOST_DEVICE double energy_unit() const { return stiffness; }
  LICHTENBERG_HOST_DEVICE PairForce operator()(const PairGeometry& pair) const {
    return force(pair, contact_law(pair.distance / pair.reach));
  }
  LICHTENBERG_HOST_DEVICE PairForce quick(const PairGeometry& pair) const {
    const double q = pair.distance / pair.reach;
    return force(pair, contact_law(q, logarithm_near_one(q)));
  }
  LICHTENBERG_HOST_DEVICE bool quick_holds(const PairGeometry& pair) const {
    return pair.distance / pair.reach >= near_one;
  }

 private:
  LICHTENBERG_HOST_DEVICE PairForce force(const PairGeometry& pair, const ContactLaw& w) const {
    return {w.energy, -stiffness * w.slope / (pair.reach * pair.distance),
            stiffness * w.curvature / (pair.reach * pair.reach)};
  }
};

}  // namespace lichtenberg::effects
