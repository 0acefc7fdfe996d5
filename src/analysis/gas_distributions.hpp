#pragma once

#include <span>
#include <vector>

#include "src/model/bodies.hpp"

namespace lichtenberg::analysis {

/// [N] (v - V)^2, V the mean velocity by mass.
std::vector<double> squared_speeds(const Bodies& bodies);
/// [N] |v - V| / <(v - V)^2>^(1/2). Nothing moves: 0. A Maxwellian gas has sqrt(54/pi) x^2 exp(-3 x^2 / 2) in space.
std::vector<double> scaled_speeds(const Bodies& bodies);
/// Second Sonine coefficient, a_2 = d/(d + 2) <v^4>/<v^2>^2 - 1, v relative to the mean: 0 of a Maxwellian gas. NaN if
/// nothing moves.
double sonine(const Bodies& bodies);

/// [N] dq / <dq^2>^(1/2), dq = q - <q>. All charges equal: 0.
std::vector<double> scaled_charges(std::span<const double> charge);
struct ChargeMoments {
  double magnitude = 0;  ///< <|q|>
  double square = 0;     ///< <q^2>
  double kurtosis = 0;   ///< <dq^4> / <dq^2>^2: 3 of Gaussian charges; NaN if all are equal
};
ChargeMoments charge_moments(std::span<const double> charge);

/// Pearson's coefficient; NaN if one of them is constant. As many of x as of y.
double correlation(std::span<const double> x, std::span<const double> y);

/// Share of the values by bins of equal width from `low` to `high`, over the width: values outside are missing from
/// the integral.
struct Histogram {
  double low = 0, high = 1;
  std::vector<double> density;

  double middle(std::size_t bin) const {
    return low + (static_cast<double>(bin) + 0.5) * (high - low) / static_cast<double>(density.size());
  }
};
Histogram histogram(std::span<const double> values, double low, double high, int bins);

}  // namespace lichtenberg::analysis
