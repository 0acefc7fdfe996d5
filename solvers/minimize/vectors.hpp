#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "solvers/larger.hpp"
#include "solvers/minimize/minimizer.hpp"

namespace lichtenberg::minimize {

/// Returns the scalar product of two vectors of the same size, in a fixed order of summation.
inline double dot(std::span<const double> a, std::span<const double> b) {
  // Four independent sums, since the compiler may not reorder a single one.
  double sum[4] = {};
  std::size_t i = 0;
  for (; i + 4 <= a.size(); i += 4)
    for (int k = 0; k < 4; ++k) sum[k] += a[i + k] * b[i + k];
  for (; i < a.size(); ++i) sum[0] += a[i] * b[i];
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}
/// Returns the Euclidean norm of a vector.
inline double norm(std::span<const double> a) { return std::sqrt(dot(a, a)); }
/// Returns the maximum norm of a vector: the largest magnitude of its components, or NaN if a component is NaN.
inline double largest(std::span<const double> a) {
  double most = 0;
  for (const double x : a) most = larger(most, std::abs(x));
  return most;
}
/// Adds a multiple of a vector to another one: y += factor * x.
inline void add(std::span<double> y, double factor, std::span<const double> x) {
  for (std::size_t i = 0; i < y.size(); ++i) y[i] += factor * x[i];
}

/// Number of vector components in a block, the work of one task of a shared loop. Blocks of many vectors fit into the
/// cache of a core.
constexpr std::size_t block = 4096;

/// Returns the number of blocks, and thus tasks, for vectors of `size` components.
inline int tasks_for(std::size_t size) { return static_cast<int>((size + block - 1) / block); }

/// Calls function(task, first, end) for each block of a vector of `size` components, by objective.share(). `task` is
/// the number of the block, and first ... end - 1 are its components.
template <class Function>
void share_blocks(const Objective& objective, std::size_t size, const Function& function) {
  objective.share(tasks_for(size), [&](int task) { function(task, block * task, std::min(block * (task + 1), size)); });
}
/// Returns the sum of function(first, end) over the blocks of a vector of `size` components; first ... end - 1 are the
/// components of a block. Threads of `objective` share the blocks. The order of summation is fixed, so the result has
/// identical bits for any number of threads.
template <class Function>
double sum_blocks(const Objective& objective, std::size_t size, const Function& function) {
  std::vector<double> partial_sums(tasks_for(size));
  share_blocks(objective, size,
               [&](int task, std::size_t first, std::size_t end) { partial_sums[task] = function(first, end); });
  double sum = 0;
  for (const double p : partial_sums) sum += p;
  return sum;
}
/// Returns the scalar product of two vectors; threads of `objective` share the blocks. The result has identical bits
/// for any number of threads.
inline double shared_dot(const Objective& objective, std::span<const double> a, std::span<const double> b) {
  return sum_blocks(objective, a.size(), [&](std::size_t first, std::size_t end) {
    return dot(a.subspan(first, end - first), b.subspan(first, end - first));
  });
}

}  // namespace lichtenberg::minimize
