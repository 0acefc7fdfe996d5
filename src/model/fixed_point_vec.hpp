#pragma once

#include <cmath>
#include <cstdint>

#include "solvers/geometry/host_device.hpp"
#include "solvers/geometry/vec.hpp"

namespace lichtenberg {

/// Vector in fixed-point numbers: integer multiples of a quantum. Sums of integers do not depend on their order, so
/// threads may add in any order.
struct FixedPointVec {
  std::int64_t x = 0, y = 0, z = 0;

  /// Returns the vector in floating point. `quantum`: value of the integer 1.
  LICHTENBERG_HOST_DEVICE Vec3 times(double quantum) const {
    return {quantum * static_cast<double>(x), quantum * static_cast<double>(y), quantum * static_cast<double>(z)};
  }
};
static_assert(sizeof(FixedPointVec) == 3 * sizeof(std::int64_t), "many are cleared as one row of numbers");

LICHTENBERG_HOST_DEVICE inline std::int64_t rounded_to_integer(double value) {
#ifdef __CUDA_ARCH__
  return __double2ll_rn(value);
#else
  return static_cast<std::int64_t>(std::nearbyint(value));
#endif
}

}  // namespace lichtenberg
