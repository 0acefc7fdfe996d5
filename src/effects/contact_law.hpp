#pragma once

#include <cmath>

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
inline double logarithm_near_one(double q) {
  const double s = (q - 1) / (q + 1), t = s * s;
  double sum = 1.0 / 15;
  for (int n = 13; n > 0; n -= 2) sum = sum * t + 1.0 / n;
  return 2 * s * sum;
}

/// The law at q, whose logarithm is given.
inline ContactLaw contact_law(double q, double logarithm) {
  const double excess = q - 1;
  return {excess * logarithm, logarithm + excess / q, (q + 1) / (q * q)};
}

inline ContactLaw contact_law(double q) { return contact_law(q, q >= near_one ? logarithm_near_one(q) : std::log(q)); }

}  // namespace lichtenberg::effects
