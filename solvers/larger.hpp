#pragma once

#include <cmath>

namespace lichtenberg {

/// Returns the maximum of a and b, or NaN if either is NaN. std::max would drop a NaN in its second argument.
inline double larger(double a, double b) { return a >= b || std::isnan(a) ? a : b; }

}  // namespace lichtenberg
