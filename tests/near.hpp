#pragma once

#include <doctest/doctest.h>

namespace lichtenberg {

/// Approximate value with a relative error. The default scale of doctest, 1, would make all small values equal.
inline doctest::Approx near(double value, double relative = 1e-9) {
  return doctest::Approx(value).epsilon(relative).scale(0);
}

}  // namespace lichtenberg
