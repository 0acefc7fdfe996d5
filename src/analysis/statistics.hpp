#pragma once

#include <optional>
#include <span>

namespace lichtenberg::analysis {

/// An estimate from a sample, with its 95 % confidence interval value +- half_width by Student's t; without one if the
/// sample is too small to have any.
struct Estimate {
  double value = 0;
  std::optional<double> half_width;
  int sample = 0;        ///< size
  double deviation = 0;  ///< of a single value of the sample about the estimate (standard deviation)
};

/// Factor t by which a standard error becomes the half width of a two-sided 95 % interval: the quantile .975 of
/// Student's distribution. `freedom`: degrees of freedom, at least 1.
double student_factor(int freedom);

/// Mean of a sample, n - 1 degrees of freedom. The sample must not be empty.
Estimate mean(std::span<const double> sample);

/// Slope a of y = a x by least squares with weights 1/x: what one counts (endpoints, branch points among x conductors)
/// varies by the square root of how many there are, so all residuals weigh the same. Then a = sum y / sum x, and its
/// variance is s^2 / sum x with s^2 = sum (y - a x)^2 / x / (n - 1) (Cochran 1977, section 6). All x > 0, at least one.
Estimate slope(std::span<const double> x, std::span<const double> y);

}  // namespace lichtenberg::analysis
