#include "src/theory/monopolar.hpp"

#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>

#include "src/theory/haff.hpp"

namespace lichtenberg::theory {
namespace {

/// Returns h(x) / sqrt(x) = sum of x^n / (n! (2n + 1)), in which no term is negative.
double series(double x) {
  double sum = 1, power = 1;
  for (int n = 1; power > 1e-17 * sum; ++n) sum += (power *= x / n) / (2 * n + 1);
  return sum;
}

/// Returns 2 sqrt(x) Dawson(sqrt(x)) = 1 + 1/(2x) + 3/(2x)^2 + 15/(2x)^3 + ... (Abramowitz & Stegun 7.1.23, continued).
/// At x >= 50 its terms fall below 1e-17 before they increase.
double asymptotic(double x) {
  double sum = 1, term = 1;
  for (int n = 1; term > 1e-17; n += 2) sum += term *= n / (2 * x);
  return sum;
}

/// Returns x for a given log_h. The bounds are sqrt(x) <= h, and for x >= 1 also h >= e^x / (2 sqrt(x)) >= e^(x/2 -
/// .2).
double x_of(double log_h_wanted) {
  const auto excess = [&](double log_x) { return log_h(std::exp(log_x)) - log_h_wanted; };
  const double margin = 1e-9;
  const double high = std::min(2 * log_h_wanted, std::log(std::max(1.0, 2 * (log_h_wanted + 0.2)))) + margin;
  double low = high - 1;
  while (excess(low) > 0) low -= 2 * (high - low);
  std::uintmax_t iterations = 200;
  const auto [below, above] =
      boost::math::tools::toms748_solve(excess, low, high, boost::math::tools::eps_tolerance<double>(52), iterations);
  return std::exp((below + above) / 2);
}

}  // namespace

double effective_barrier(double barrier, double filling) {
  const double x = std::cbrt(filling);
  return barrier * std::max(1 - 2.40 * x + 1.44 * x * x, 0.0);
}

double log_h(double x) {
  return x < 50 ? std::log(series(x)) + 0.5 * std::log(x) : x + std::log(asymptotic(x)) - std::log(2 * std::sqrt(x));
}

double monopolar_temperature(const MonopolarGas& gas, double time) {
  if (gas.barrier == 0) return haff_temperature(gas.initial, gas.tau, time);
  const double start = gas.barrier / gas.initial, before = log_h(start);
  const double grown = std::log1p(time / gas.tau * std::exp(0.5 * std::log(start) - before));
  return std::min(gas.initial, gas.barrier / x_of(before + grown));
}

double monopolar_time(const MonopolarGas& gas, double temperature) {
  if (gas.barrier == 0) return gas.tau * (std::sqrt(gas.initial / temperature) - 1);
  const double start = gas.barrier / gas.initial, before = log_h(start), now = log_h(gas.barrier / temperature);
  return gas.tau / std::sqrt(start) * std::exp(before) * std::expm1(now - before);
}

}  // namespace lichtenberg::theory
