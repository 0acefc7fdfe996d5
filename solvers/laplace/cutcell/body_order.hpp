#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

/// A problem with its bodies sorted by the grid row of their centre (of a bar: its first end). Loops over bodies then
/// access cells that are close in memory, and each thread has approximately the same rows in loops over bodies and
/// cells.
class BodyOrder {
 public:
  /// Sorts by `rows` rows of equal height; within a row the bodies keep the problem's order.
  void sort(const LaplaceProblem& problem, int rows);
  const LaplaceProblem& sorted() const { return sorted_; }
  /// Returns the index in the problem of a body of the sorted problem.
  int index(int body) const { return index_[body]; }
  /// Reorders values by body from the sorted problem's order to the problem's.
  template <class Value>
  void restore(std::vector<Value>& value) const {
    std::vector<Value> restored(value.size());
    for (std::size_t body = 0; body < value.size(); ++body) restored[index_[body]] = value[body];
    value = std::move(restored);
  }

 private:
  LaplaceProblem sorted_;
  std::vector<int> index_;
};

}  // namespace lichtenberg::laplace
