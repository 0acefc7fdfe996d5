#pragma once

#include <algorithm>
#include <vector>

#include "solvers/parallel/team.hpp"

namespace lichtenberg {

/// Number of bodies in a range. A pass over them costs a few times as much as handing them to a thread. The number is
/// fixed, so that rounding in a range does not depend on the number of threads.
constexpr int bodies_a_range = 1024;

/// Calls work(first, end) for ranges that cover the bodies 0 ... n - 1, divided among the team. The result for one body
/// must not depend on the results for others.
template <class Work>
void for_ranges(parallel::Team& team, int n, const Work& work) {
  team.for_each((n + bodies_a_range - 1) / bodies_a_range, [&](int range) {
    const int first = range * bodies_a_range;
    work(first, std::min(n, first + bodies_a_range));
  });
}

/// Returns the maximum of `least` and of the results of work(first, end) for the ranges of for_ranges().
template <class Work>
double largest_of_ranges(parallel::Team& team, int n, double least, const Work& work) {
  std::vector<double> found((n + bodies_a_range - 1) / bodies_a_range);
  for_ranges(team, n, [&](int first, int end) { found[first / bodies_a_range] = work(first, end); });
  for (const double value : found) least = std::max(least, value);
  return least;
}

/// Returns the minimum of `most` and of the results of work(first, end) for the ranges of for_ranges().
template <class Work>
double least_of_ranges(parallel::Team& team, int n, double most, const Work& work) {
  return -largest_of_ranges(team, n, -most, [&](int first, int end) { return -work(first, end); });
}

}  // namespace lichtenberg
