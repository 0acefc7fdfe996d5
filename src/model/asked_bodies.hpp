#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "src/model/neighbours.hpp"

namespace lichtenberg {

/// Bodies whose forces are asked for, time and again while others move so little that they come no nearer to them: a
/// look at their neighbours costs what they are, not what all are.
class AskedBodies {
 public:
  /// In ascending order; empty: all bodies.
  explicit AskedBodies(std::vector<int> bodies = {}) : bodies_(std::move(bodies)) {}

  std::span<const int> bodies() const { return bodies_; }
  /// The pairs of `list` that one of them is in, which is brought up to date: at the first call wherever bodies have
  /// moved, later where these have.
  std::span<const Pair> neighbours(NeighbourList& list, const Bodies& all, parallel::Team& team);

 private:
  std::vector<int> bodies_;
  std::vector<Pair> pairs_;
  std::int64_t search_ = -1;  ///< of the list, that `pairs_` are of; -1: none yet
};

}  // namespace lichtenberg
