#pragma once

#include <span>
#include <vector>

#include "src/model/bodies.hpp"

namespace lichtenberg::analysis {

/// Computes the squared speeds relative to the mean flow: (v - V)^2 (v0^2) [N], with V the mass-weighted mean velocity
/// of all grains.
std::vector<double> squared_speeds(const Bodies& bodies);
/// Computes scaled speeds |v - V| / <(v - V)^2>^(1/2) [N], with V the mass-weighted mean velocity; 0 for a gas at rest.
/// In a Maxwellian gas of equal grains in three dimensions their distribution is sqrt(54/pi) x^2 exp(-3 x^2 / 2).
std::vector<double> scaled_speeds(const Bodies& bodies);
/// Computes the second Sonine coefficient of the velocities, a_2 = d/(d + 2) <v^4>/<v^2>^2 - 1, in d dimensions, with v
/// relative to the mass-weighted mean velocity. It is 0 for Maxwell's distribution of v and NaN for a gas at rest.
double sonine(const Bodies& bodies);

/// Computes scaled charges dq / <dq^2>^(1/2) [N], with dq = q - <q>; 0 if all charges are equal.
std::vector<double> scaled_charges(std::span<const double> charge);
/// Moments of the distribution of charges over the grains.
struct ChargeMoments {
  double magnitude = 0;  ///< <|q|>
  double square = 0;     ///< <q^2>
  double kurtosis = 0;   ///< <dq^4> / <dq^2>^2: 3 for Gaussian charges; NaN if all are equal
};
/// Computes the mean magnitude, mean square and kurtosis of the grains' charges.
ChargeMoments charge_moments(std::span<const double> charge);

/// Computes Pearson's correlation coefficient of x and y, which have the same length; NaN if x or y is constant.
double correlation(std::span<const double> x, std::span<const double> y);

/// Histogram as a probability density: the fraction of all values that lie in each bin, divided by the bin width. Bins
/// have equal width from `low` to `high`. Values outside reduce the integral below 1.
struct Histogram {
  double low = 0, high = 1;
  std::vector<double> density;

  /// Returns the value in the middle of the bin of this index (0: the lowest bin).
  double middle(std::size_t bin) const {
    return low + (static_cast<double>(bin) + 0.5) * (high - low) / static_cast<double>(density.size());
  }
};
/// Makes the histogram of the values in `bins` bins from `low` to `high`.
Histogram histogram(std::span<const double> values, double low, double high, int bins);

}  // namespace lichtenberg::analysis
