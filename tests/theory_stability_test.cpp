#include <doctest/doctest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include "solvers/error.hpp"
#include "src/theory/stability.hpp"
#include "tests/near.hpp"

namespace theory_stability_test {

using namespace lichtenberg::theory;
using lichtenberg::near;

namespace {

std::vector<double> up_to(double last, int count) {
  std::vector<double> k;
  for (int n = 1; n <= count; ++n) k.push_back(last * n / count);
  return k;
}

/// G 6.39 as printed.
Eigen::Matrix4cd printed_matrix(const TransportCoefficients& c, double r, double k) {
  const std::complex<double> i(0, 1);
  Eigen::Matrix4cd m;
  m << 0, 0, -i * k, 0,  //
      -c.cooling / 2 - 2.5 * c.density_conduction * k * k, -c.cooling / 4 - 2.5 * c.conduction * k * k,
      -2.0 / 3 * i * k, 0,                                                                   //
      -i * k / 2.0, -i * k / 2.0, c.cooling / 4 - 4.0 / 3 * c.viscosity * k * k, r * i * k,  //
      0, 0, -1.0 / (i * k), 0;
  return m;
}

}  // namespace

TEST_CASE("transport_coefficients: known values at restitution 0.7 and 1") {
  const TransportCoefficients c = transport_coefficients(0.7);  // Ten digits from the source's script.
  CHECK(c.cooling == near(0.2125520337, 3e-10));
  CHECK(c.viscosity == near(1.147863019, 5e-10));
  CHECK(c.conduction == near(1.357967483, 5e-10));
  CHECK(c.density_conduction == near(0.4837346101, 2e-10));
  const TransportCoefficients elastic = transport_coefficients(1);
  CHECK(elastic.cooling == 0);
  CHECK(elastic.viscosity == 1);
  CHECK(elastic.conduction == 1);
  CHECK(elastic.density_conduction == 0);
  for (const double refused : {0.0, -0.1, 1.1, std::nan("")})
    CHECK_THROWS_AS(transport_coefficients(refused), lichtenberg::InputError);
}

TEST_CASE("hydrodynamic_length and charge_number: known values for a gas") {
  const double density = 50016 / (70.0 * 70 * 70);
  CHECK(hydrodynamic_length(density) * density == near(0.12467, 4e-5));
  CHECK(hydrodynamic_length(density) == near(0.855, 1e-3));
  // R = 2 pi K n q^2 l_0^2 / T.
  CHECK(charge_number(2, density, 3, 5) == near(2 * M_PI * 2 * density * 9 * std::pow(0.12467 / density, 2) / 5, 1e-4));
}

TEST_CASE("growth_rates: equal the eigenvalues of the printed matrix") {
  for (const double eps : {0.3, 0.7, 0.99})
    for (const double r : {0.0, 0.1, 0.9})
      for (const double k : {0.01, 0.12, 0.3, 2.0}) {
        const TransportCoefficients c = transport_coefficients(eps);
        const Eigen::Vector4cd printed =
            Eigen::ComplexEigenSolver<Eigen::Matrix4cd>(printed_matrix(c, r, k)).eigenvalues();
        const Modes found = growth_rates(c, r, std::vector{k})[0];
        // Rounding of a matrix with 1/k, whose eigenvalues are simple here, some of them barely.
        const double bound = 1e-9;
        CHECK(std::ranges::any_of(printed, [&](auto root) { return std::abs(root) < bound; }));
        for (const auto root : found.longitudinal)
          CHECK(std::ranges::any_of(printed, [&](auto p) { return std::abs(p - root) < bound; }));
        const Cubic cubic = characteristic(c, r, k);
        for (const auto root : found.longitudinal)
          // A determinant of three rows as large as the trace, each rounded about ten times.
          CHECK(std::abs(((root + cubic.a) * root + cubic.b) * root + cubic.c) < 3e-15 * std::pow(1 + cubic.a, 3));
        // Routh-Hurwitz criterion.
        const bool stable = std::ranges::all_of(found.longitudinal, [](auto root) { return root.real() < 0; });
        CHECK((cubic.a > 0 && cubic.c > 0 && cubic.a * cubic.b > cubic.c) == stable);
      }
}

TEST_CASE("growth_rates: limits for wave number 0, and sound of an elastic gas") {
  const TransportCoefficients c = transport_coefficients(0.7);
  const double k = 1e-5, r = 0.1;
  const Modes charged = growth_rates(c, r, std::vector{k})[0];
  CHECK(charged.longitudinal[0].real() == near(c.cooling / 8, 1e-7));
  CHECK(charged.longitudinal[0].imag() == near(std::sqrt(r - c.cooling * c.cooling / 64), 1e-7));
  CHECK(charged.longitudinal[1] == std::conj(charged.longitudinal[0]));
  CHECK(charged.longitudinal[2].real() == near(-c.cooling / 4, 1e-7));
  const Modes neutral = growth_rates(c, 0, std::vector{k})[0];
  CHECK(neutral.longitudinal[0].real() == near(c.cooling / 4, 1e-6));
  CHECK(neutral.longitudinal[2].real() == near(-c.cooling / 4, 1e-6));
  CHECK(std::abs(neutral.longitudinal[1]) < 1e-8);
  // omega = k sqrt(gamma/2), gamma = 5/3, in units of sqrt(2T/m).
  const Modes sound = growth_rates(transport_coefficients(1), 0, std::vector{1e-4})[0];
  double omega = 0;
  for (const auto root : sound.longitudinal) omega = std::max(omega, root.imag());
  CHECK(omega == near(1e-4 * std::sqrt(5.0 / 6), 1e-6));
}

TEST_CASE("growth_rates: are continuous in the wave number") {
  const double step = 0.0005;
  for (const double eps : {0.3, 0.5, 0.7, 0.9})
    for (const double r : {0.0, 0.001, 0.003, 0.01, 0.1, 0.9}) {
      const auto modes = growth_rates(transport_coefficients(eps), r, up_to(600 * step, 600));
      for (std::size_t n = 1; n < modes.size(); ++n)
        for (int m = 0; m < 3; ++m)
          // Two branches meet in a square root, where they change by sqrt(step) times a number below one.
          CHECK(std::abs(modes[n].longitudinal[m] - modes[n - 1].longitudinal[m]) < std::sqrt(step));
    }
  const Modes one = growth_rates(transport_coefficients(0.7), 0, std::vector{0.2})[0];
  CHECK(one.shear == near(0.2125520337 / 4 - 1.147863019 * 0.04, 1e-8));
}

namespace {

/// (M - root) d with M of G 6.39.
Disturbance without(const TransportCoefficients& c, double r, double k, const Disturbance& d,
                    std::complex<double> root) {
  return {-k * d.speed - root * d.density,
          -(c.cooling / 2 + 2.5 * c.density_conduction * k * k) * d.density -
              (c.cooling / 4 + 2.5 * c.conduction * k * k + root) * d.temperature - 2.0 / 3 * k * d.speed,
          (k / 2 + r / k) * d.density + k / 2 * d.temperature +
              (c.cooling / 4 - 4.0 / 3 * c.viscosity * k * k - root) * d.speed};
}

}  // namespace

TEST_CASE("disturbance_evolution: each eigenmode grows as exp(rate times time)") {
  const TransportCoefficients c = transport_coefficients(0.7);
  const double k = 0.12, r = 0.3, later = 20;
  const Disturbance start{{1, 0.5}, {-0.7, 0.1}, {0.2, 0.9}};
  const auto roots = growth_rates(c, r, std::vector{k})[0].longitudinal;
  const auto found = disturbance_evolution(c, r, false, k, start, std::vector{0.0, later});
  REQUIRE(found.size() == 2);
  CHECK(found[0].speed == start.speed);
  for (int n = 0; n < 3; ++n) {
    // (M - root) removes the mode of this root; two such factors leave one mode.
    const auto alone = [&](const Disturbance& d) {
      return without(c, r, k, without(c, r, k, d, roots[(n + 1) % 3]), roots[(n + 2) % 3]);
    };
    const auto grown = std::exp(roots[n] * later);
    // 1e-10 per step over some hundred steps.
    CHECK(std::abs(alone(found[1]).density - grown * alone(start).density) < 1e-7);
    CHECK(std::abs(alone(found[1]).speed - grown * alone(start).speed) < 1e-7);
  }
}

TEST_CASE("disturbance_evolution, constant charges: charge number grows as 1/T") {
  const TransportCoefficients c = transport_coefficients(0.7);
  const double k = 0.12, r = 0.3, later = 20, step = 0.05;
  const Disturbance start{1, 0, 0};
  Disturbance stepped = start;
  for (double t = 0; t < later - step / 2; t += step)
    stepped =
        disturbance_evolution(c, r * std::exp(c.cooling / 2 * (t + step / 2)), false, k, stepped, std::vector{step})[0];
  const Disturbance found = disturbance_evolution(c, r, true, k, start, std::vector{later})[0];
  // The stepwise R is of second order: (step^2/24) R'' over a time of 20, and the commutator of M with M', each below
  // 0.1.
  CHECK(std::abs(found.density - stepped.density) < 1e-3 * std::abs(found.speed));
  CHECK(std::abs(found.speed - stepped.speed) < 1e-3 * std::abs(found.speed));
}

TEST_CASE("critical_waves: equal those of the Routh-Hurwitz criterion") {
  const TransportCoefficients c = transport_coefficients(0.7);
  const auto neutral = critical_waves(c, 0);
  REQUIRE(neutral.size() == 1);
  CHECK(neutral[0].wave_number == near(0.1559261895, 4e-10));
  CHECK_FALSE(neutral[0].oscillates);
  CHECK(critical_shear(c) == near(0.2151580525, 3e-10));
  for (const double eps : {0.3, 0.5, 0.7, 0.8, 0.95})
    for (const double r : {0.0, 0.003, 0.01, 0.05, 0.2, 0.9}) {
      const TransportCoefficients then = transport_coefficients(eps);
      const auto found = critical_waves(then, r), same = routh_hurwitz_waves(then, r);
      REQUIRE(found.size() == same.size());
      for (std::size_t n = 0; n < found.size(); ++n) {
        CHECK(found[n].wave_number == near(same[n].wave_number, 1e-11));
        CHECK(found[n].oscillates == same[n].oscillates);
      }
      if (r > 0) CHECK(std::ranges::any_of(found, &CriticalWave::oscillates));
    }
}

}  // namespace theory_stability_test
