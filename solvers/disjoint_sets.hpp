#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

namespace lichtenberg {

/// Union-find structure: a partition of the numbers 0 ... n - 1 into disjoint sets that can be united (path halving).
/// Initially each number is a set of its own. The smallest member represents a set, so that the order of unions does
/// not affect results.
class DisjointSets {
 public:
  explicit DisjointSets(int n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }
  /// Returns the smallest member of the set that contains i. Two numbers are in one set if and only if their results
  /// are equal.
  int find(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  /// Unites the sets that contain i and j. Returns false if i and j already were in the same set.
  bool unite(int i, int j) {
    i = find(i), j = find(j);
    parent_[std::max(i, j)] = std::min(i, j);
    return i != j;
  }

 private:
  std::vector<int> parent_;
};

}  // namespace lichtenberg
