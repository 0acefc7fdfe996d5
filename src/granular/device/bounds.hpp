#pragma once

// Bounds of charged grains in domains that are not periodic: sides that no charge may cross, and extents of a cloud,
// from which its mesh follows.

#include <cmath>

#include "solvers/periodic/bounded.hpp"
#include "src/granular/device/contact_data.hpp"

namespace lichtenberg::granular::device {

/// Lowest and highest coordinates of grains (d0). Operator + gives those of both, for reductions.
struct Span {
  Vec3 low{INFINITY, INFINITY, INFINITY}, high{-INFINITY, -INFINITY, -INFINITY};

  LICHTENBERG_HOST_DEVICE Span& operator+=(const Span& o) {
    for (int k = 0; k < 3; ++k) {
      if (o.low[k] < low[k]) low[k] = o.low[k];
      if (o.high[k] > high[k]) high[k] = o.high[k];
    }
    return *this;
  }
  friend LICHTENBERG_HOST_DEVICE Span operator+(Span a, const Span& b) { return a += b; }
};

/// Bounds of charges in a domain: of their positions between sides that are not periodic, and of their extents in an
/// unbounded domain. Reduced units.
struct ChargeBounds {
  bool unbounded = false;
  Box<3> box;
  Vec3 above, most;  ///< of extents of an unbounded domain: the largest that are too small, and the largest

  /// Length (d0) by which the extents may grow in a step. The mesh of an unbounded domain is longer by it.
  static constexpr double growth = 1;

  /// Returns 1 + the index of a side that a charge has crossed; 0 if there is none.
  LICHTENBERG_HOST_DEVICE int side_crossed(const Span& span) const {
    for (int k = 0; k < 3 && !unbounded; ++k) {
      if (box.periodic(k)) continue;
      if (!(span.low[k] >= 0)) return 1 + 2 * k;
      if (!(span.high[k] <= box.lengths[k])) return 2 + 2 * k;
    }
    return 0;
  }
  /// Returns true if the extents of an unbounded domain require another mesh.
  LICHTENBERG_HOST_DEVICE bool outgrown(const Span& span) const {
    bool fits = true;
    for (int k = 0; k < 3; ++k) {
      const double extent = span.high[k] - span.low[k];
      fits = fits && extent > above[k] && extent <= most[k];
    }
    return unbounded && !fits;
  }
  /// Sets the bounds of extents around those of an unbounded domain, to neighbouring lengths 2^(n/8).
  void surround(const Span& span) {
    for (int k = 0; k < 3; ++k) {
      const double extent = span.high[k] - span.low[k];
      most[k] = periodic::rounded_up(extent);
      above[k] = extent > 0 ? most[k] * std::exp2(-0.125) : -1;
      // Rounding must not put the extent outside of its bounds.
      if (!(extent > above[k])) most[k] = above[k], above[k] *= std::exp2(-0.125);
      if (!(extent <= most[k])) above[k] = most[k], most[k] *= std::exp2(0.125);
    }
  }
};

/// Returns the span of the grains' positions on a device.
template <class Executor>
Span span_of(const Executor& run, const GrainsView& grains) {
  parallel::Array<Span, Executor> span(run);
  span.resize(1);
  Span* to = span.data();
  const Vec3* position = grains.position;
  run.template sum<1>(
      grains.count,
      [=] LICHTENBERG_HOST_DEVICE(int s) {
        return Span{position[s], position[s]};
      },
      [=] LICHTENBERG_HOST_DEVICE(const Span& all) { *to = all; });
  return span.download().front();
}

/// Kernel launch of an outer step: checks that the charges are within their bounds, and sets the results that stop the
/// series of steps otherwise.
template <class Executor>
void check_bounds(const Executor& run, const GrainsView& grains, const ChargeBounds& bounds, StepResults* results) {
  const Vec3* position = grains.position;
  run.template sum<1>(
      grains.count,
      [=] LICHTENBERG_HOST_DEVICE(int s) {
        return Span{position[s], position[s]};
      },
      [=] LICHTENBERG_HOST_DEVICE(const Span& all) {
        results->crossed = bounds.side_crossed(all);
        results->outgrown = bounds.outgrown(all);
      });
}

}  // namespace lichtenberg::granular::device
