#pragma once

#include <optional>
#include <span>
#include <vector>

namespace lichtenberg::analysis {

/// [N] ln(S(t)/S(t/p)) / ln p at each time (G 4.11), S between two times by a power of t; NaN where t/p is before the
/// first. Times > 0 and rising, sizes > 0.
std::vector<double> local_slopes(std::span<const double> time, std::span<const double> size, double p = 2);

/// S = amplitude (t + shift)^exponent: without the shift, what went before makes exponents at finite times too small.
struct ShiftedPower {
  double amplitude = 0, shift = 0, exponent = 0;
  double scatter = 0;  ///< rms of ln S about it
};

/// Least squares in ln S. Empty if no shift is best, but for a singular one at the first time or one of ten times the
/// last: the size grows slower or faster than any power then. Throws InputError unless there are five points or more
/// with times > 0, rising, and sizes > 0.
std::optional<ShiftedPower> fit_growth(std::span<const double> time, std::span<const double> size);

}  // namespace lichtenberg::analysis
