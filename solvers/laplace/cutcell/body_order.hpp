#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

/// A problem with its bodies sorted by the row of a grid that their centre lies in (of a bar its first end). What loops
/// over bodies reads cells that lie near each other in memory then, and of a loop that threads share each has about the
/// rows that it has of loops over cells.
class BodyOrder {
 public:
  /// By `rows` rows of equal height; in a row the bodies stay in the problem's order.
  void sort(const LaplaceProblem& problem, int rows);
  const LaplaceProblem& sorted() const { return sorted_; }
  /// Index in the problem of the sorted one's body.
  int index(int body) const { return index_[body]; }
  /// Takes one value a body from the sorted problem's order to the problem's.
  template <class Value>
  void restore(std::vector<Value>& of_body) const {
    std::vector<Value> restored(of_body.size());
    for (std::size_t body = 0; body < of_body.size(); ++body) restored[index_[body]] = of_body[body];
    of_body = std::move(restored);
  }

 private:
  LaplaceProblem sorted_;
  std::vector<int> index_;
};

}  // namespace lichtenberg::laplace
