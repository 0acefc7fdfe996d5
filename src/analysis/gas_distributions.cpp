#include "src/analysis/gas_distributions.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace lichtenberg::analysis {
namespace {

double mean(std::span<const double> values) {
  return values.empty() ? 0 : std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double mean_square(std::span<const double> values) {
  return values.empty() ? 0
                        : std::inner_product(values.begin(), values.end(), values.begin(), 0.0) /
                              static_cast<double>(values.size());
}

/// Subtracts the mean. The result is exactly 0 if all values are equal, which rounding of the mean would not give.
std::vector<double> centred(std::span<const double> values) {
  std::vector<double> result(values.begin(), values.end());
  const bool equal = std::ranges::all_of(values, [&](double value) { return value == values.front(); });
  const double middle = equal && !values.empty() ? values.front() : mean(values);
  for (double& value : result) value -= middle;
  return result;
}

/// Returns <x^2> / <x>^2 of squares x.
double flatness(std::span<const double> squares) {
  const double middle = mean(squares);
  return middle > 0 ? mean_square(squares) / (middle * middle) : NAN;
}

std::vector<double> scaled(std::vector<double> values) {
  const double square = mean_square(values);
  for (double& value : values) value = square > 0 ? value / std::sqrt(square) : 0;
  return values;
}

}  // namespace

std::vector<double> squared_speeds(const Bodies& b) {
  std::vector<double> flow(b.dimension), squares(b.size());
  const double mass = std::accumulate(b.mass.begin(), b.mass.end(), 0.0);
  const double* p = b.momentum.data();
  for (int i = 0; i < b.size(); ++i)
    for (int k = 0; k < b.dimension; ++k) flow[k] += *p++ / mass;
  p = b.momentum.data();
  for (int i = 0; i < b.size(); ++i)
    for (int k = 0; k < b.dimension; ++k) {
      const double speed = *p++ / b.mass[i] - flow[k];
      squares[i] += speed * speed;
    }
  return squares;
}

std::vector<double> scaled_speeds(const Bodies& bodies) {
  std::vector<double> speeds = squared_speeds(bodies);
  for (double& speed : speeds) speed = std::sqrt(speed);
  return scaled(std::move(speeds));
}

double sonine(const Bodies& bodies) {
  const double d = bodies.dimension;
  return d / (d + 2) * flatness(squared_speeds(bodies)) - 1;
}

std::vector<double> scaled_charges(std::span<const double> charge) { return scaled(centred(charge)); }

ChargeMoments charge_moments(std::span<const double> charge) {
  ChargeMoments moments{.square = mean_square(charge)};
  for (const double q : charge) moments.magnitude += std::abs(q) / static_cast<double>(charge.size());
  std::vector<double> squares = centred(charge);
  for (double& q : squares) q *= q;
  moments.kurtosis = flatness(squares);
  return moments;
}

double correlation(std::span<const double> x, std::span<const double> y) {
  const std::vector<double> dx = centred(x), dy = centred(y);
  const double xx = mean_square(dx), yy = mean_square(dy);
  if (!(xx > 0 && yy > 0)) return NAN;
  return std::inner_product(dx.begin(), dx.end(), dy.begin(), 0.0) / static_cast<double>(dx.size()) /
         std::sqrt(xx * yy);
}

Histogram histogram(std::span<const double> values, double low, double high, int bins) {
  Histogram found{low, high, std::vector<double>(bins)};
  const double width = (high - low) / bins;
  for (const double value : values) {
    const double bin = std::floor((value - low) / width);
    if (bin >= 0 && bin < bins)
      found.density[static_cast<std::size_t>(bin)] += 1 / (width * static_cast<double>(values.size()));
  }
  return found;
}

}  // namespace lichtenberg::analysis
