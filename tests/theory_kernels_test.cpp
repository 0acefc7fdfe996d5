#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "solvers/error.hpp"
#include "src/theory/coagulation_kernels.hpp"
#include "tests/near.hpp"

namespace theory_kernels_test {

using namespace lichtenberg;
using namespace lichtenberg::theory;
using doctest::Approx;

// Smoluchowski's equation with K = i j: M_0 = 1 - t/2, M_2 = 1/(1 - t), f_k = k^(k-2) t^(k-1) e^(-k t) / k! for t < 1.
TEST_CASE("power_kernel, product of sizes: closed form before gelation") {
  const std::vector<double> sizes = size_classes(800, 2, 800), times = {0.25, 0.5, 0.7};
  const auto found = coagulate(power_kernel(1, 1), sizes, times);
  REQUIRE(found.size() == times.size());
  for (const SizeDistribution& f : found) {
    const double t = f.time;
    // A relative tolerance of 1e-8 per step over some hundred steps.
    CHECK(f.moment(sizes, 0) == near(1 - t / 2, 1e-6));
    CHECK(f.moment(sizes, 2) == near(1 / (1 - t), 1e-6));
    for (const int k : {1, 2, 20})
      CHECK(f.number[k - 1] ==
            near(std::exp((k - 2) * std::log(k) + (k - 1) * std::log(t) - k * t - std::lgamma(k + 1)), 1e-5));
  }
}

// The gel point is t = 1. At t = 0.5, aggregates of 1e3 grains have less than e^-190 of the mass.
TEST_CASE("power_kernel, product of sizes: few sizes lose mass at gelation") {
  const std::vector<double> sizes = size_classes(60, 1.1, 1e3);
  CHECK(coagulate(power_kernel(1, 1), sizes, std::vector{0.5, 1.1}).size() == 1);
}

TEST_CASE("power_kernel, product of sizes: mass is lost at gelation" * doctest::test_suite("long")) {
  const std::vector<double> sizes = size_classes(60, 1.1, 1e5);
  // The gel point is t = 1; aggregates of 1e5 grains have 1e-9 of the mass a little before it.
  const auto found = coagulate(power_kernel(1, 1), sizes, std::vector{0.9, 1.1});
  CHECK(found.size() == 1);
}

TEST_CASE("power_kernel: mean of sizes is half of Golovin's kernel") {
  const std::vector<double> sizes = size_classes(600, 2, 600);
  const auto found = coagulate(power_kernel(1, 0), sizes, std::vector{2.0});
  REQUIRE(found.size() == 1);
  CHECK(found[0].moment(sizes, 0) == near(std::exp(-1), 1e-6));
  CHECK(found[0].moment(sizes, 2) == near(std::exp(2), 1e-6));
  CHECK(power_kernel(0, 0)(3, 7) == 1);
}

// The sum over all pairs of the Brownian kernel is dM_0/dt = -(M_0^2 + M_(1/3) M_(-1/3)).
TEST_CASE("brownian_kernel: loss of number equals its moment equation") {
  const std::vector<double> sizes = size_classes(300, 2, 300);
  const double t = 2, step = 1e-3;  // the difference is of second order: 1e-6
  const auto found = coagulate(brownian_kernel(), sizes, std::vector{t - step, t, t + step});
  REQUIRE(found.size() == 3);
  const double slope = (found[2].moment(sizes, 0) - found[0].moment(sizes, 0)) / (2 * step);
  const auto moment = [&](double power) { return found[1].moment(sizes, power); };
  CHECK(slope == near(-(moment(0) * moment(0) + moment(1.0 / 3) * moment(-1.0 / 3)), 1e-5));
  CHECK(brownian_kernel()(1, 1) == near(4, 1e-15));
  CHECK(brownian_kernel()(30, 50) == near(brownian_kernel()(3, 5), 1e-14));
}

TEST_CASE("repelled kernel: Fuchs's factor of touching charged spheres") {
  const Kernel kernel = repelled(power_kernel(0, 0), 0.3);
  CHECK(kernel(1, 1) == near(0.3 / std::expm1(0.3), 1e-15));
  // x = 0.3 * 2 * 8 * 27 / (2 + 3).
  CHECK(kernel(8, 27) == near(25.92 / std::expm1(25.92), 1e-14));
  CHECK(repelled(power_kernel(0, 0), 1e-12)(1, 1) == near(1, 1e-11));
  const double largest = largest_repelled_size(0.3);
  CHECK(kernel(largest, largest) < 1e-297);
  CHECK(kernel(largest / 1.01, largest / 1.01) > 1e-297);
}

// The two smallest aggregates merge next if barriers are high. Sizes from m to 2m then have the density s^-2, and the
// relative width sqrt(1/(2 ln^2 2) - 1) = 0.20170.
TEST_CASE("repelled Brownian kernel: width falls toward its extremal limit") {
  const double extremal = std::sqrt(1 / (2 * std::pow(std::numbers::ln2, 2)) - 1);
  CHECK(extremal == Approx(0.2017).epsilon(1e-4));
  for (const double repulsion : {0.02, 0.05}) {
    const CoagulationSeries found =
        coagulation_series(repelled(brownian_kernel(), repulsion), std::vector{1e2, 1e6, 1e12},
                           {.tolerance = 1e-3, .largest = 4 * largest_repelled_size(repulsion) / 8, .stiff = true});
    REQUIRE(found.size.size() == 3);
    const std::vector<double> width = found.relative_width();
    CHECK(width[0] > width[1]);
    CHECK(width[1] > width[2]);
    CHECK(width[2] > extremal);
    // A barrier of 47 temperatures at t = 1e12, and an excess of the width of order 1/barrier^2 (measured: 0.005).
    CHECK(width[2] < extremal + 0.01);
  }
}

TEST_CASE("coagulate, stiff: equals the solution by Adams formulas") {
  const std::vector<double> sizes = size_classes(60, 1.1, 3000), times = {1, 10};
  const auto adams = coagulate(brownian_kernel(), sizes, times),
             stiff = coagulate(brownian_kernel(), sizes, times, 1e-9, true);
  REQUIRE(stiff.size() == 2);
  for (int k = 0; k < 2; ++k)
    CHECK(stiff[k].mean_size(sizes) == near(adams[k].mean_size(sizes), 1e-5));  // 1e-7 per step
}

TEST_CASE("table_kernel: exact for a power law, also beyond the table") {
  KernelTable table{.size = {1, 3, 40}, .value = {}};
  for (const double i : table.size) {
    table.value.emplace_back();
    for (const double j : table.size) table.value.back().push_back(2 * std::pow(i * j, 0.25));
  }
  const Kernel kernel = table_kernel(table);
  for (const double i : {1.0, 2.0, 3.0, 17.0, 500.0})
    for (const double j : {1.0, 39.0, 800.0}) CHECK(kernel(i, j) == near(2 * std::pow(i * j, 0.25), 1e-13));
}

TEST_CASE("table_kernel: wrong tables are refused") {
  const std::vector<std::vector<double>> good{{1, 2}, {2, 3}};
  CHECK_NOTHROW(table_kernel({{1, 2}, good}));
  CHECK_THROWS_AS(table_kernel({{1}, {{1}}}), InputError);
  CHECK_THROWS_AS(table_kernel({{2, 1}, good}), InputError);
  CHECK_THROWS_AS(table_kernel({{0, 1}, good}), InputError);
  CHECK_THROWS_AS(table_kernel({{1, 2, 3}, good}), InputError);
  CHECK_THROWS_AS(table_kernel({{1, 2}, {{1, 2}, {2}}}), InputError);
  CHECK_THROWS_AS(table_kernel({{1, 2}, {{1, 2}, {2.5, 3}}}), InputError);
  CHECK_THROWS_AS(table_kernel({{1, 2}, {{1, 0}, {0, 3}}}), InputError);
}

}  // namespace theory_kernels_test
