#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "solvers/geometry/vec.hpp"
#include "solvers/neighbours/pairs.hpp"

namespace lichtenberg::granular {

/// Pairs by the substep at which their gap is tested.
class ContactSchedule {
 public:
  /// Begins with no pairs, for substeps 0 to `steps`.
  void begin(int steps) {
    if (static_cast<int>(due_.size()) <= steps) due_.resize(steps + 1);
    for (std::vector<Pair>& pairs : due_) pairs.clear();
    steps_ = steps;
  }
  /// Adds a pair to substep n; has no effect after the last one.
  void add(double n, Pair pair) {
    if (n <= steps_) due_[static_cast<int>(n)].push_back(pair);
  }
  std::vector<Pair>& due(int n) { return due_[n]; }

 private:
  int steps_ = 0;
  std::vector<std::vector<Pair>> due_;
};

/// Relative motion of two points: separation r, velocity v and constant acceleration a.
struct RelativeFlight {
  Vec3 r, v, a;
};

/// Returns the time at which the distance |r + v t + a t^2/2| of two points falls below `reach`; infinite if it does
/// not within `longest`. The time is exact up to rounding, except for grazing motions, where it is too early.
inline double earliest_contact(const RelativeFlight& flight, double reach, double longest) {
  const auto [r, v, a] = flight;
  const double fastest = norm(v) + longest * norm(a);
  double t = 0;
  for (int k = 0; k < 60; ++k) {
    const double gap = norm(r + t * (v + 0.5 * t * a)) - reach;
    if (gap <= 1e-12 * reach) return t;
    t += gap / fastest;
    if (!(t < longest)) return INFINITY;
  }
  return t;
}

}  // namespace lichtenberg::granular
