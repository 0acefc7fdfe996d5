#pragma once

// Weights of a charge's mesh points.

#include <cmath>
#include <cstdint>

#include "solvers/geometry/host_device.hpp"
#include "solvers/parallel/unroll.hpp"

namespace lichtenberg::periodic::device {

/// Window of a mesh on a device: computes the weights of the `order` mesh points around a charge along one axis. They
/// are polynomials of the offset t (spacings, -1/2 to 1/2) from the middle between two points.
template <int order>
struct Weigher {
  float term[order][order];  ///< Coefficient of t^d in the c-th weight: [d][c]

  /// Computes the weights [order] at the offset t.
  LICHTENBERG_HOST_DEVICE void weights(float t, float* weight) const {
    LICHTENBERG_UNROLL(8)
    for (int c = 0; c < order; ++c) {
      float value = term[order - 1][c];
      LICHTENBERG_UNROLL(8)
      for (int d = order - 2; d >= 0; --d) value = value * t + term[d][c];
      weight[c] = value;
    }
  }
  /// Computes the weights [order] at the offset t, and their derivatives with respect to t.
  LICHTENBERG_HOST_DEVICE void weights(float t, float* weight, float* slope) const {
    LICHTENBERG_UNROLL(8)
    for (int c = 0; c < order; ++c) {
      float value = term[order - 1][c], by_t = 0;
      LICHTENBERG_UNROLL(8)
      for (int d = order - 2; d >= 0; --d) by_t = by_t * t + value, value = value * t + term[d][c];
      weight[c] = value, slope[c] = by_t;
    }
  }
};

/// Computes the second derivatives of a window's weights [order] at the offset t.
template <int order>
LICHTENBERG_HOST_DEVICE void curvatures(const Weigher<order>& window, float t, float* curvature) {
  LICHTENBERG_UNROLL(8)
  for (int c = 0; c < order; ++c) {
    float value = 0;
    LICHTENBERG_UNROLL(8)
    for (int d = order - 1; d >= 2; --d) value = value * t + static_cast<float>(d * (d - 1)) * window.term[d][c];
    curvature[c] = value;
  }
}

/// Position on the mesh along one axis: the preceding mesh point, and the offset (spacings, -1/2 to 1/2) from the
/// middle between it and the next point.
struct OnMesh {
  int point = 0;
  float from_middle = 0;

  LICHTENBERG_HOST_DEVICE OnMesh(std::uint32_t coordinate, int points) {
    const std::uint64_t product = static_cast<std::uint64_t>(coordinate) * static_cast<std::uint64_t>(points);
    point = static_cast<int>(product >> 32);
    from_middle =
        static_cast<float>(static_cast<std::int32_t>(static_cast<std::uint32_t>(product) - 0x80000000u)) * 0x1p-32f;
  }
};

/// Rounds to the nearest integer of the type Whole.
template <class Whole>
LICHTENBERG_HOST_DEVICE inline Whole rounded_to_integer(float value) {
#ifdef __CUDA_ARCH__
  if constexpr (sizeof(Whole) == 8) return __float2ll_rn(value);
  return static_cast<Whole>(__float2int_rn(value));
#else
  return static_cast<Whole>(std::nearbyint(value));
#endif
}

}  // namespace lichtenberg::periodic::device
