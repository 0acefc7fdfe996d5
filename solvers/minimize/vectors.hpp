#pragma once

#include <algorithm>
#include <cmath>
#include <span>

namespace lichtenberg::minimize {

inline double dot(std::span<const double> a, std::span<const double> b) {
  // Four sums at a time, or the compiler must add one after the other.
  double sum[4] = {};
  std::size_t i = 0;
  for (; i + 4 <= a.size(); i += 4)
    for (int k = 0; k < 4; ++k) sum[k] += a[i + k] * b[i + k];
  for (; i < a.size(); ++i) sum[0] += a[i] * b[i];
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}
inline double norm(std::span<const double> a) { return std::sqrt(dot(a, a)); }
/// The largest magnitude.
inline double largest(std::span<const double> a) {
  double most = 0;
  for (const double x : a) most = std::max(most, std::abs(x));
  return most;
}
/// y += factor * x
inline void add(std::span<double> y, double factor, std::span<const double> x) {
  for (std::size_t i = 0; i < y.size(); ++i) y[i] += factor * x[i];
}

}  // namespace lichtenberg::minimize
