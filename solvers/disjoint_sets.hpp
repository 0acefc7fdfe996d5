#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

namespace lichtenberg {

/// A partition of 0 ... n - 1 that grows coarser: union-find with path halving. A set is named after its smallest
/// member, so that what is numbered by sets does not depend on the order in which they were joined.
class DisjointSets {
 public:
  explicit DisjointSets(int n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }
  /// The smallest member of i's set.
  int find(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  /// False if i and j are in one set already.
  bool unite(int i, int j) {
    i = find(i), j = find(j);
    parent_[std::max(i, j)] = std::min(i, j);
    return i != j;
  }

 private:
  std::vector<int> parent_;
};

}  // namespace lichtenberg
