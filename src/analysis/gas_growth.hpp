#pragma once

#include <optional>
#include <span>
#include <vector>

namespace lichtenberg::analysis {

/// Computes the local growth exponent of a size S(t): ln(S(t)/S(t/p)) / ln p [N] at each time (G 4.11). S is
/// interpolated between two times by a power of t. NaN if t/p is before the first time. Times must be > 0 and in
/// ascending order, sizes > 0.
std::vector<double> local_slopes(std::span<const double> time, std::span<const double> size, double p = 2);

/// Power law of a mean cluster size S over time t: S = amplitude (t + shift)^exponent. A positive shift describes a
/// slow initial stage; a fit without it would give too small an exponent at finite times.
struct ShiftedPower {
  double amplitude = 0, shift = 0, exponent = 0;
  double scatter = 0;  ///< rms deviation of ln S from the law
};

/// Fits the power law S = amplitude (t + shift)^exponent by least squares in ln S. Empty if the best shift is at a
/// limit of the search: just above -time.front(), or about 10 time.back(). Throws InputError unless there are at least
/// five finite sizes > 0 at finite times > 0 in ascending order.
std::optional<ShiftedPower> fit_growth(std::span<const double> time, std::span<const double> size);

}  // namespace lichtenberg::analysis
