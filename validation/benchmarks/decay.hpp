#pragma once

#include <cmath>
#include <optional>

// Extrapolation of a convergence history, for methods that a benchmark does not run to the end.

namespace lichtenberg::benchmarks {

/// Point of a convergence history.
struct Sample {
  double at, value;  ///< Number of iterations or time (s); error or force, in any unit
};

/// Extrapolates a convergence history: computes the abscissa (iterations or s) at which the exponential decay through
/// `middle` and `last` reaches `target`. Empty if the samples do not decrease, or if the result exceeds `farthest`
/// times the length of the history. A rate from one interval is not reliable many intervals later.
inline std::optional<double> end_of_decay(Sample middle, Sample last, double target, double farthest = 10) {
  if (!(last.value > 0) || !(target > 0) || !(last.at > middle.at)) return std::nullopt;
  const double rate = std::log(middle.value / last.value) / (last.at - middle.at);
  if (!(rate > 0) || !std::isfinite(rate)) return std::nullopt;
  const double end = last.at + std::log(last.value / target) / rate;
  if (!(end >= last.at) || end > farthest * last.at) return std::nullopt;
  return end;
}

}  // namespace lichtenberg::benchmarks
