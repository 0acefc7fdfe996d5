#pragma once

#include <cmath>

namespace lichtenberg {

/// The larger number, and NaN if either is none: std::max would drop it.
inline double larger(double a, double b) { return a >= b || std::isnan(a) ? a : b; }

}  // namespace lichtenberg
