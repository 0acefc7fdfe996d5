#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

namespace lichtenberg {

/// Partition of 0 ... n - 1 whose sets can be united: union-find with path halving. A set is identified by its smallest
/// member, so that numberings by sets do not depend on the order of unions.
class DisjointSets {
 public:
  explicit DisjointSets(int n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }
  /// Returns the smallest member of i's set.
  int find(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  /// Unites two sets. Returns false if i and j are in one set already.
  bool unite(int i, int j) {
    i = find(i), j = find(j);
    parent_[std::max(i, j)] = std::min(i, j);
    return i != j;
  }

 private:
  std::vector<int> parent_;
};

}  // namespace lichtenberg
