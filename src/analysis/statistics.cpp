#include "src/analysis/statistics.hpp"

#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <numeric>

namespace lichtenberg::analysis {

double student_factor(int freedom) { return quantile(boost::math::students_t(freedom), 0.975); }

Estimate mean(std::span<const double> sample) {
  const int n = static_cast<int>(sample.size());
  Estimate result{.value = std::accumulate(sample.begin(), sample.end(), 0.0) / n, .sample = n};
  if (n < 2) return result;
  double squares = 0;
  for (const double value : sample) squares += (value - result.value) * (value - result.value);
  result.deviation = std::sqrt(squares / (n - 1));
  result.half_width = student_factor(n - 1) * result.deviation / std::sqrt(n);
  return result;
}

Estimate slope(std::span<const double> x, std::span<const double> y) {
  const int n = static_cast<int>(x.size());
  const double all_x = std::accumulate(x.begin(), x.end(), 0.0);
  Estimate result{.value = std::accumulate(y.begin(), y.end(), 0.0) / all_x, .sample = n};
  if (n < 2) return result;
  double squares = 0;
  for (int k = 0; k < n; ++k) squares += (y[k] - result.value * x[k]) * (y[k] - result.value * x[k]) / x[k];
  result.deviation = std::sqrt(squares / (n - 1));  // standard deviation at x = 1
  result.half_width = student_factor(n - 1) * result.deviation / std::sqrt(all_x);
  return result;
}

}  // namespace lichtenberg::analysis
