#pragma once

#include <cmath>

namespace lichtenberg::effects {

/// w(q) = (q - 1) ln q and its derivatives by q, for 0 < q <= 1. w(1) = w'(1) = 0 and w''(1) = 2, so beyond contact,
/// where nothing acts, the second derivative jumps to 0. Towards q = 0 there is no limit: w ~ -ln q, w' ~ -1/q.
struct ContactLaw {
  double energy = 0, slope = 0, curvature = 0;
};

inline ContactLaw contact_law(double q) {
  // ln q = log1p(q - 1) keeps the digits of q - 1, which is exact: just inside contact w is a square of it.
  const double excess = q - 1, logarithm = std::log1p(excess);
  return {excess * logarithm, logarithm + excess / q, (q + 1) / (q * q)};
}

}  // namespace lichtenberg::effects
