#pragma once

#include <span>
#include <vector>

#include "src/model/bodies.hpp"

namespace lichtenberg::analysis {

/// Returns (v - V)^2 [N], V the mass-weighted mean velocity.
std::vector<double> squared_speeds(const Bodies& bodies);
/// Returns |v - V| / <(v - V)^2>^(1/2) [N]; 0 for a gas at rest. A Maxwellian gas in three dimensions has the
/// distribution sqrt(54/pi) x^2 exp(-3 x^2 / 2).
std::vector<double> scaled_speeds(const Bodies& bodies);
/// Returns the second Sonine coefficient, a_2 = d/(d + 2) <v^4>/<v^2>^2 - 1, v relative to the mean. It is 0 for a
/// Maxwellian gas and NaN for a gas at rest.
double sonine(const Bodies& bodies);

/// Returns dq / <dq^2>^(1/2) [N], dq = q - <q>; 0 if all charges are equal.
std::vector<double> scaled_charges(std::span<const double> charge);
struct ChargeMoments {
  double magnitude = 0;  ///< <|q|>
  double square = 0;     ///< <q^2>
  double kurtosis = 0;   ///< <dq^4> / <dq^2>^2: 3 for Gaussian charges; NaN if all are equal
};
ChargeMoments charge_moments(std::span<const double> charge);

/// Returns Pearson's correlation coefficient; NaN if x or y is constant. x and y have the same length.
double correlation(std::span<const double> x, std::span<const double> y);

/// Fraction of the values in each bin, divided by the bin width. Bins have equal width from `low` to `high`. Values
/// outside are missing from the integral.
struct Histogram {
  double low = 0, high = 1;
  std::vector<double> density;

  double middle(std::size_t bin) const {
    return low + (static_cast<double>(bin) + 0.5) * (high - low) / static_cast<double>(density.size());
  }
};
Histogram histogram(std::span<const double> values, double low, double high, int bins);

}  // namespace lichtenberg::analysis
