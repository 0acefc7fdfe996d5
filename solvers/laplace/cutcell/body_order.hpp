#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

/// Problem with its bodies sorted by the grid row of their centres (of a bar: of the first end of its longer axis).
/// Loops over bodies then access cells that are close in memory. In loops over bodies and in loops over cells, a thread
/// works on approximately the same rows.
class BodyOrder {
 public:
  /// Sorts the bodies by the row of their centres. `rows`: number of rows of equal height that divide the box. Within a
  /// row the bodies keep the problem's order.
  void sort(const LaplaceProblem& problem, int rows);
  /// Returns the problem with sorted bodies.
  const LaplaceProblem& sorted() const { return sorted_; }
  /// Returns the index in the original problem of a body of the sorted problem.
  int index(int body) const { return index_[body]; }
  /// Reorders values by body from the sorted order to the original problem's order.
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
