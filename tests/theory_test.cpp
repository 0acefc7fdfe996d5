#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "validation/harness.hpp"
#include "validation/theory/two_disks.hpp"

namespace theory_test {

using namespace lichtenberg;
using namespace lichtenberg::theory;
using doctest::Approx;
using std::numbers::pi;

namespace {

DiskPair equal_pair(double d_over_2r) { return {{{0, 0}, 1}, {{2 * d_over_2r, 0}, 1}, 1}; }
const DiskPair unequal = {{{0.3, -0.2}, 0.7}, {{1.5, 1.4}, 1.1}, 2.5};  // At distance 2 with gap 0.2, oblique.

Vec2 on_circle(const Disk& disk, double angle) {
  return disk.centre + disk.radius * (1 + 1e-12) * Vec2{std::cos(angle), std::sin(angle)};
}

/// Central differences of the potential with step 1e-5: truncation 1e-10, rounding 1e-11 of the potential's scale.
Vec2 gradient(const DiskPair& pair, double charge, Vec2 p) {
  const double s = 1e-5;
  return {(potential(pair, charge, p + Vec2{s, 0}) - potential(pair, charge, p - Vec2{s, 0})) / (2 * s),
          (potential(pair, charge, p + Vec2{0, s}) - potential(pair, charge, p - Vec2{0, s})) / (2 * s)};
}

/// Charge and force by integrals over a circle slightly larger than the disk. With 400 points they converge
/// geometrically.
struct Integrals {
  double charge = 0;
  Vec2 force;
};
Integrals integrals(const DiskPair& pair, double charge, const Disk& disk, double radius) {
  const int n = 400;
  Integrals sum;
  for (int k = 0; k < n; ++k) {
    const Vec2 normal = {std::cos(2 * pi * k / n), std::sin(2 * pi * k / n)};
    const Vec2 g = gradient(pair, charge, disk.centre + radius * normal);
    const double ds = 2 * pi * radius / n;
    sum.charge += -pair.permittivity * dot(g, normal) * ds;
    sum.force += pair.permittivity * ds * (dot(g, normal) * g - 0.5 * norm2(g) * normal);
  }
  return sum;
}

}  // namespace

TEST_CASE("two equal disks: capacitance is pi eps / acosh(d / 2R)") {
  for (const double ratio : {1.02, 1.25, 2.0, 8.0})
    CHECK(capacitance(equal_pair(ratio)) == Approx(pi / std::acosh(ratio)).epsilon(1e-13));
}

TEST_CASE("two disks at d = 2.1 R: capacitance and force of a reference solution") {
  // 13 digits of a published reference solution: two disks of radius 1, centres at distance 2.1, eps = 1, Q = 1.
  CHECK(capacitance(equal_pair(1.05)) == Approx(9.97569288444885).epsilon(1e-13));
  CHECK(force(equal_pair(1.05), 1).x == Approx(0.24855826185828295).epsilon(1e-13));
}

TEST_CASE("two unequal disks: each surface is an equipotential") {
  for (double angle = 0; angle < 6; angle += 0.5) {
    // The points lie 1e-12 radii off the surface; the field there is below 10 V/m.
    CHECK(potential(unequal, 1, on_circle(unequal.positive, angle)) ==
          Approx(positive_potential(unequal, 1)).epsilon(1e-10));
    CHECK(potential(unequal, 1, on_circle(unequal.negative, angle)) ==
          Approx(negative_potential(unequal, 1)).epsilon(1e-10));
  }
}

TEST_CASE("inside a disk: the potential is that of its surface") {
  CHECK(potential(unequal, 1, unequal.positive.centre) == positive_potential(unequal, 1));
  CHECK(potential(unequal, 1, unequal.negative.centre) == negative_potential(unequal, 1));
}

TEST_CASE("two disks: potential difference is charge over capacitance") {
  const double charge = 3;
  CHECK(positive_potential(unequal, charge) - negative_potential(unequal, charge) ==
        Approx(charge / capacitance(unequal)).epsilon(1e-13));
}

TEST_CASE("two disks: the potential vanishes at large distances") {
  // A dipole of moment Q 2a, 2a < 2: V < Q 2a / (2 pi eps r) = 1.3e-7 at r = 1e6.
  CHECK(std::abs(potential(unequal, 1, {1e6, 3e5})) < 1.3e-7);
}

TEST_CASE("two disks: flux and Maxwell stress around each give charge and force") {
  const double charge = 1.7;
  const Integrals first = integrals(unequal, charge, unequal.positive, 0.75);
  const Integrals second = integrals(unequal, charge, unequal.negative, 1.15);
  const Vec2 expected = force(unequal, charge);
  CHECK(first.charge == Approx(charge).epsilon(1e-7));
  CHECK(second.charge == Approx(-charge).epsilon(1e-7));
  CHECK(norm(first.force - expected) < 1e-7 * norm(expected));
  CHECK(norm(second.force + expected) < 1e-7 * norm(expected));
}

TEST_CASE("two disks: force is the energy's negative derivative") {
  // W = Q^2 / 2C. Central differences with step 1e-5 have a relative truncation error of (step / gap)^2 = 2.5e-9.
  const double charge = 1.7, s = 1e-5;
  const auto energy = [&](double shift) {
    DiskPair moved = unequal;
    moved.positive.centre.x += shift;
    return charge * charge / (2 * capacitance(moved));
  };
  CHECK(force(unequal, charge).x == Approx(-(energy(s) - energy(-s)) / (2 * s)).epsilon(1e-7));
}

TEST_CASE("two disks: capacitance keeps its digits at a gap of 2e-10 R") {
  // acosh(1 + x) = sqrt(2 x) (1 - x / 12 + ...): at x = 1e-10 the correction is 1e-11. The gap of such a pair is
  // rounded by 1e-16 / 1e-10.
  CHECK(capacitance(equal_pair(1 + 1e-10)) == Approx(pi / std::sqrt(2e-10)).epsilon(1e-6));
}

TEST_CASE("descent theory: error decays as (1 - eta C)^2, or 1 - 2 eta C if small") {
  // eta C = 0.25: one step multiplies the error by 0.75^2.
  CHECK(std::exp(-error_decay_rate(0.05, 5)) == Approx(0.5625));
  CHECK(small_step_decay_rate(0.05, 5) == Approx(0.5));
  // -2 ln(1 - x) = 2 x (1 + x / 2 + ...).
  CHECK(error_decay_rate(1e-6, 5) == Approx(small_step_decay_rate(1e-6, 5)).epsilon(5e-6));
}

TEST_CASE("validation report: a NaN or an empty sample violates every bound") {
  const double nan = std::nan("");
  for (const std::vector<double>& sample : {std::vector<double>{nan, 1}, {1, nan}, {1, nan, 2}, {}}) {
    CHECK(std::isnan(validation::spread(sample).worst));
    validation::Report report("a sample that no bound may keep");
    report.at_most("sample", validation::spread(sample), 10);
    CHECK(report.exit_status() == 1);
  }
  CHECK(validation::spread({1, -3, 2}).worst == 3);
}

}  // namespace theory_test
