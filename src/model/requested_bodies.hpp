#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "src/model/neighbours.hpp"

namespace lichtenberg {

/// Subset of the bodies whose forces are computed repeatedly, with the neighbour pairs of these bodies. Between these
/// computations, the other bodies must come no nearer to the requested ones. Most updates test only the requested
/// bodies, not all bodies.
class RequestedBodies {
 public:
  /// Requests the forces on `bodies`, indices in ascending order; empty: all bodies.
  explicit RequestedBodies(std::vector<int> bodies = {}) : bodies_(std::move(bodies)) {}

  std::span<const int> bodies() const { return bodies_; }
  /// Updates the neighbour list and returns its pairs that contain a requested body. The first call rebuilds the list
  /// if any body has moved too far; a later call rebuilds it only if a requested body has moved too far.
  std::span<const Pair> neighbours(NeighbourList& list, const Bodies& all, parallel::Team& team);

 private:
  std::vector<int> bodies_;
  std::vector<Pair> pairs_;
  std::int64_t search_ = -1;  ///< rebuild number of the list from which `pairs_` comes; -1: none yet
};

}  // namespace lichtenberg
