#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "solvers/error.hpp"
#include "src/analysis/gas_growth.hpp"

namespace analysis_growth_test {

using namespace lichtenberg;
using doctest::Approx;

namespace {

struct Series {
  std::vector<double> time, size;
};
Series shifted_power(double amplitude, double shift, double exponent, double noise = 0) {
  Series series;
  for (int k = 0; k < 40; ++k) {
    series.time.push_back(2 * std::pow(1.15, k));
    series.size.push_back(amplitude * std::pow(series.time[k] + shift, exponent) * std::exp(noise * std::sin(7.0 * k)));
  }
  return series;
}

}  // namespace

TEST_CASE("fit_growth: recovers amplitude, shift and exponent of A (t + shift)^z") {
  for (const double shift : {-1.5, 0.0, 3.0, 50.0}) {
    const auto [time, size] = shifted_power(0.3, shift, 1.49);
    const analysis::ShiftedPower fit = *analysis::fit_growth(time, size);
    // Brent's method finds a minimum of squares to the root of the rounding, and the shift for times up to 500.
    CHECK(fit.exponent == Approx(1.49).epsilon(1e-5));
    CHECK(std::abs(fit.shift - shift) < 1e-3);
    CHECK(fit.amplitude == Approx(0.3).epsilon(1e-3));
    CHECK(fit.scatter < 1e-5);
  }
  const auto [time, size] = shifted_power(2, 1, 1.2, 0.05);
  const analysis::ShiftedPower fit = *analysis::fit_growth(time, size);
  CHECK(fit.scatter == Approx(0.05 / std::sqrt(2)).epsilon(0.1));
  CHECK(std::abs(fit.exponent - 1.2) < 0.05);  // scatter / sqrt(40) over a span of ln 250, and as much for the shift.
}

TEST_CASE("local_slopes: exponent of a power law, lower if the time is shifted") {
  const auto [time, size] = shifted_power(0.3, 0, 1.5);
  const std::vector<double> slopes = analysis::local_slopes(time, size);
  CHECK(std::isnan(slopes[4]));  // 2 (1.15)^4 / 2 < 2
  for (std::size_t k = 5; k < time.size(); ++k) CHECK(slopes[k] == Approx(1.5).epsilon(1e-12));
  const auto later = shifted_power(0.3, 20, 1.5);
  CHECK(analysis::local_slopes(later.time, later.size).back() < 1.48);
}

TEST_CASE("fit_growth: exponential growth gives no exponent") {
  Series fast = shifted_power(1, 0, 1);
  for (double& s : fast.size) s = std::exp(s / 30);
  CHECK_FALSE(analysis::fit_growth(fast.time, fast.size));
}

TEST_CASE("fit_growth: too few, unordered, zero or NaN values are refused") {
  const std::vector<double> time = {1, 2, 3, 4, 5}, size = {1, 2, 3, 4, 5};
  CHECK_NOTHROW(analysis::fit_growth(time, size));
  CHECK_THROWS_AS(analysis::fit_growth(std::span(time).first(4), std::span(size).first(4)), InputError);
  for (const std::vector<double>& bad :
       std::vector<std::vector<double>>{{0, 1, 2, 3, 4}, {1, 2, 2, 3, 4}, {1, 2, 3, 4, NAN}})
    CHECK_THROWS_AS(analysis::fit_growth(bad, size), InputError);
  CHECK_THROWS_AS(analysis::fit_growth(time, std::vector<double>{1, 2, 0, 3, 4}), InputError);
}

}  // namespace analysis_growth_test
