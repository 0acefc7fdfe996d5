#pragma once

#include <span>
#include <vector>

#include "solvers/neighbours/pairs.hpp"

namespace lichtenberg {

/// Two grains in contact, from touch to release.
struct GrainContact {
  Pair pair;
  double since = 0;         ///< time of touch
  double impact_speed = 0;  ///< at which they closed then, along the line of centres
  bool alone = true;        ///< neither has touched a third since
};

/// A contact that has ended.
struct Collision {
  GrainContact contact;
  double release_speed = 0;     ///< at which they separate when their surfaces part
  double end = 0;               ///< time of that
  double tangential_speed = 0;  ///< across the line of centres, then
};

/// What the contacts did while grains were moved by dt, up to `time`.
struct ContactRecord {
  double time = 0, dt = 0;
  std::vector<GrainContact> begun;  ///< in the order of the steps, and within one of the pairs
  std::vector<Collision> ended;
  std::span<const GrainContact> open;  ///< at the end, in ascending order of pairs
  double dissipated = 0;
  double largest_overlap = 0;  ///< over the sum of radii
};

}  // namespace lichtenberg
