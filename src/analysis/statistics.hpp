#pragma once

#include <optional>
#include <span>

namespace lichtenberg::analysis {

/// An estimate from a sample, with its 95 % confidence interval value +- half_width by Student's t. Samples of one
/// value have no interval.
struct Estimate {
  double value = 0;
  std::optional<double> half_width;
  int sample = 0;        ///< size of the sample
  double deviation = 0;  ///< standard deviation of a single value about the estimate; of slope() at x = 1
};

/// Returns the factor t that converts a standard error to the half width of a two-sided 95 % interval: the quantile
/// .975 of Student's distribution. `freedom`: degrees of freedom, at least 1.
double student_factor(int freedom);

/// Computes the mean of a sample and its confidence interval, with n - 1 degrees of freedom. The sample must not be
/// empty.
Estimate mean(std::span<const double> sample);

/// Fits the slope a of y = a x by least squares with weights 1/x (ratio estimator), with its confidence interval. The
/// weights suit counts (such as endpoints of x conductors), whose standard deviation is about proportional to the
/// square root of x. Then a = sum y / sum x, and its variance is s^2 / sum x with s^2 = sum (y - a x)^2 / x / (n - 1)
/// (Cochran 1977, section 6). All x > 0, at least one.
Estimate slope(std::span<const double> x, std::span<const double> y);

}  // namespace lichtenberg::analysis
