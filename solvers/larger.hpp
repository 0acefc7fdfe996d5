#pragma once

#include <cmath>

namespace lichtenberg {

/// Returns the larger number, or NaN if either is NaN, which std::max would not return.
inline double larger(double a, double b) { return a >= b || std::isnan(a) ? a : b; }

}  // namespace lichtenberg
