#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "solvers/larger.hpp"
#include "solvers/minimize/minimizer.hpp"

namespace lichtenberg::minimize {

inline double dot(std::span<const double> a, std::span<const double> b) {
  // Four independent sums, since the compiler may not reorder a single one.
  double sum[4] = {};
  std::size_t i = 0;
  for (; i + 4 <= a.size(); i += 4)
    for (int k = 0; k < 4; ++k) sum[k] += a[i + k] * b[i + k];
  for (; i < a.size(); ++i) sum[0] += a[i] * b[i];
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}
inline double norm(std::span<const double> a) { return std::sqrt(dot(a, a)); }
/// Returns the largest magnitude; NaN if there is one.
inline double largest(std::span<const double> a) {
  double most = 0;
  for (const double x : a) most = larger(most, std::abs(x));
  return most;
}
/// Adds: y += factor * x.
inline void add(std::span<double> y, double factor, std::span<const double> x) {
  for (std::size_t i = 0; i < y.size(); ++i) y[i] += factor * x[i];
}

/// Number of components per task of a shared loop: this many stay in a core's cache while many vectors are processed.
constexpr std::size_t block = 4096;

inline int tasks_for(std::size_t size) { return static_cast<int>((size + block - 1) / block); }

/// Calls part(task, first, end) for every block of `size` components.
template <class Function>
void share_blocks(const Objective& objective, std::size_t size, const Function& function) {
  objective.share(tasks_for(size), [&](int task) { function(task, block * task, std::min(block * (task + 1), size)); });
}
/// Returns the sum of part(first, end) over all blocks, in their order.
template <class Function>
double sum_blocks(const Objective& objective, std::size_t size, const Function& function) {
  std::vector<double> partial_sums(tasks_for(size));
  share_blocks(objective, size,
               [&](int task, std::size_t first, std::size_t end) { partial_sums[task] = function(first, end); });
  double sum = 0;
  for (const double p : partial_sums) sum += p;
  return sum;
}
inline double shared_dot(const Objective& objective, std::span<const double> a, std::span<const double> b) {
  return sum_blocks(objective, a.size(), [&](std::size_t first, std::size_t end) {
    return dot(a.subspan(first, end - first), b.subspan(first, end - first));
  });
}

}  // namespace lichtenberg::minimize
