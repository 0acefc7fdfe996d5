#pragma once

#include <cmath>

#include "src/model/pair_law.hpp"

namespace lichtenberg::effects {

/// w(q) = (q - 1) ln q and its derivatives by q, for 0 < q <= 1. w(1) = w'(1) = 0 and w''(1) = 2, so beyond contact,
/// where nothing acts, the second derivative jumps to 0. Towards q = 0 there is no limit: w ~ -ln q, w' ~ -1/q.
struct ContactLaw {
  double energy = 0, slope = 0, curvature = 0;
};

/// From here on to 1 `logarithm_near_one` knows the digits of ln q.
constexpr double near_one = 0.8;

/// ln q = 2 artanh(s) with s = (q - 1) / (q + 1) (Abramowitz & Stegun 4.1.27): |s| <= 1/9, and s^17 / 17, the first
/// term left out, is below the rounding of s. No branches, so that a loop takes many at a time. q - 1 is exact, and all
/// its digits are kept: just inside contact w is a square of it.
LICHTENBERG_HOST_DEVICE inline double logarithm_of_ratio(double s) {
  const double t = s * s;
  double sum = 1.0 / 15;
  for (int n = 13; n > 0; n -= 2) sum = sum * t + 1.0 / n;
  return 2 * s * sum;
}
LICHTENBERG_HOST_DEVICE inline double logarithm_near_one(double q) { return logarithm_of_ratio((q - 1) / (q + 1)); }

/// The law at q, whose logarithm is given.
LICHTENBERG_HOST_DEVICE inline ContactLaw contact_law(double q, double logarithm) {
  const double excess = q - 1;
  return {excess * logarithm, logarithm + excess / q, (q + 1) / (q * q)};
}

LICHTENBERG_HOST_DEVICE inline ContactLaw contact_law(double q) {
  return contact_law(q, q >= near_one ? logarithm_near_one(q) : std::log(q));
}

/// U = stiffness w(q) between two particles, q their distance over the sum of their radii (pair_law.hpp).
struct ContactPotentialLaw {
  static constexpr bool over_distance = true, damped = false;
  double stiffness = 1;  ///< J

  LICHTENBERG_HOST_DEVICE double reach(double radius_i, double radius_j) const { return radius_i + radius_j; }
  LICHTENBERG_HOST_DEVICE double energy_unit() const { return stiffness; }
  LICHTENBERG_HOST_DEVICE PairForce operator()(const PairSeen& seen) const {
    return force(seen, contact_law(seen.distance / seen.reach));
  }
  LICHTENBERG_HOST_DEVICE PairForce quick(const PairSeen& seen) const {
    const double q = seen.distance / seen.reach;
    return force(seen, contact_law(q, logarithm_near_one(q)));
  }
  LICHTENBERG_HOST_DEVICE bool quick_holds(const PairSeen& seen) const {
    return seen.distance / seen.reach >= near_one;
  }

 private:
  LICHTENBERG_HOST_DEVICE PairForce force(const PairSeen& seen, const ContactLaw& w) const {
    return {w.energy, -stiffness * w.slope / (seen.reach * seen.distance),
            stiffness * w.curvature / (seen.reach * seen.reach)};
  }
};

}  // namespace lichtenberg::effects
