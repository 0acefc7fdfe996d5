#pragma once

#include "solvers/geometry/host_device.hpp"

namespace lichtenberg {

/// Consecutive indices of a ring: `count` of the indices 0 ... size - 1, from `first` on. Index 0 follows size - 1.
struct RingRange {
  int first = 0, count = 0, size = 0;

  /// Returns the range of all n indices.
  static RingRange whole(int n) { return {0, n, n}; }
  /// Returns the k-th index.
  LICHTENBERG_HOST_DEVICE int operator()(int k) const {
    const int index = first + k;
    return index < size ? index : index - size;
  }
  LICHTENBERG_HOST_DEVICE bool contains(int index) const {
    const int after = index - first;
    return (after < 0 ? after + size : after) < count;
  }
};

}  // namespace lichtenberg
