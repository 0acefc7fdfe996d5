#pragma once

#include <span>
#include <vector>

#include "solvers/neighbours/pairs.hpp"

namespace lichtenberg {

/// Two grains in contact, from onset to release.
struct GrainContact {
  Pair pair;
  double since = 0;         ///< time of onset
  double impact_speed = 0;  ///< closing speed at onset, along the line of centres
  bool alone = true;        ///< no third grain has been in contact with either since onset
};

/// A contact that has ended.
struct Collision {
  GrainContact contact;
  double release_speed = 0;     ///< opening speed when the surfaces separate
  double end = 0;               ///< time of separation
  double tangential_speed = 0;  ///< speed across the line of centres at separation
};

/// Contact events while grains were moved by dt, up to `time`.
struct ContactRecord {
  double time = 0, dt = 0;
  std::vector<GrainContact> begun;  ///< in the order of the steps, and within a step in the order of the pairs
  std::vector<Collision> ended;
  std::span<const GrainContact> open;  ///< contacts open at the end, in ascending order of pairs
  double dissipated = 0;
  double largest_overlap = 0;  ///< largest ratio of overlap to sum of radii
};

}  // namespace lichtenberg
