#pragma once

#include <span>
#include <vector>

#include "solvers/neighbours/pairs.hpp"

namespace lichtenberg {

/// A contact of two grains from its onset on. Units are the reduced ones (t0, v0).
struct GrainContact {
  Pair pair;
  double since = 0;         ///< time of onset
  double impact_speed = 0;  ///< closing speed at onset, along the line of centres
  bool alone = true;        ///< true if no third grain has been in contact with one of the two since onset
};

/// A contact of two grains that has ended, with the time and the speeds of the separation. Units are the reduced ones
/// (t0, v0).
struct Collision {
  GrainContact contact;
  double release_speed = 0;     ///< opening speed along the line of centres at separation
  double end = 0;               ///< time of separation
  double tangential_speed = 0;  ///< relative speed across the line of centres at separation
};

/// Contacts of grains that began or ended from `time` - dt to `time`, and those that have not ended at `time`. Also the
/// energy that contacts dissipated in this interval. Units are the reduced ones (t0, m0 v0^2).
struct ContactRecord {
  double time = 0, dt = 0;
  std::vector<GrainContact> begun;  ///< in the order of the steps, and within a step in the order of the pairs
  std::vector<Collision> ended;
  std::span<const GrainContact> open;  ///< contacts open at `time`, in ascending order of pairs
  double dissipated = 0;               ///< energy
  double largest_overlap = 0;          ///< largest ratio of overlap to sum of radii
};

}  // namespace lichtenberg
