#pragma once

#include <algorithm>
#include <vector>

#include "solvers/parallel/ranges.hpp"

namespace lichtenberg {

/// Number of successive bodies in one task of for_ranges(). A loop over one range costs a few times as much as handing
/// a task to a thread. The number is fixed, so that rounding does not depend on the number of threads.
constexpr int bodies_a_range = 1024;

/// Runs a parallel loop over the bodies 0 ... n - 1. The team's threads call work(first, end) for successive ranges of
/// bodies, first <= i < end. The result for one body must not depend on the results for others.
template <class Work>
void for_ranges(parallel::Team& team, int n, const Work& work) {
  parallel::for_each_range<bodies_a_range>(n, team, work);
}

/// Returns the maximum of work(first, end) over the ranges of bodies of for_ranges(), but at least `least`.
template <class Work>
double largest_of_ranges(parallel::Team& team, int n, double least, const Work& work) {
  std::vector<double> found((n + bodies_a_range - 1) / bodies_a_range);
  for_ranges(team, n, [&](int first, int end) { found[first / bodies_a_range] = work(first, end); });
  for (const double value : found) least = std::max(least, value);
  return least;
}

/// Returns the minimum of work(first, end) over the ranges of bodies of for_ranges(), but at most `most`.
template <class Work>
double least_of_ranges(parallel::Team& team, int n, double most, const Work& work) {
  return -largest_of_ranges(team, n, -most, [&](int first, int end) { return -work(first, end); });
}

}  // namespace lichtenberg
