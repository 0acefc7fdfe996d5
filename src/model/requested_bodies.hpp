#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "src/model/neighbours.hpp"

namespace lichtenberg {

/// Requested bodies, whose forces are computed repeatedly while the other bodies come no nearer to them. The cost of
/// their neighbours depends on their number and not on the number of all bodies.
class RequestedBodies {
 public:
  /// Requests these bodies. `bodies`: indices in ascending order; empty: all bodies.
  explicit RequestedBodies(std::vector<int> bodies = {}) : bodies_(std::move(bodies)) {}

  std::span<const int> bodies() const { return bodies_; }
  /// Returns the pairs of `list` that contain a requested body, after an update of the list. The first call updates it
  /// for all moved bodies, later calls only for moved requested bodies.
  std::span<const Pair> neighbours(NeighbourList& list, const Bodies& all, parallel::Team& team);

 private:
  std::vector<int> bodies_;
  std::vector<Pair> pairs_;
  std::int64_t search_ = -1;  ///< rebuild number of the list from which `pairs_` comes; -1: none yet
};

}  // namespace lichtenberg
