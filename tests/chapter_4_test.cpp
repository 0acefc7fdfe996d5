// Tests of D's chapter 4, the charge shuttle and the broken wire, against independent numbers.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "solvers/error.hpp"
#include "validation/theory/broken_wire.hpp"
#include "validation/theory/disk_between_plates.hpp"
#include "validation/theory/shuttle.hpp"
#include "validation/theory/two_disks.hpp"

namespace chapter_4_test {

using namespace lichtenberg;
using namespace lichtenberg::theory;
using doctest::Approx;
using std::numbers::pi;

namespace {

constexpr double permittivity = 4.7 * 8.8541878128e-12, radius = 0.775e-3;

SphereShuttle shuttle_of(double gap) {
  return {radius, gap, 18e3, permittivity, 6 * pi * 0.7 * radius, isolated_sphere_capacitance(radius, permittivity)};
}

BrokenWire wire_of_d() {
  return {25, radius, 40e-3, 18e3, permittivity, isolated_sphere_capacitance(radius, permittivity)};
}

DiskBetweenPlates disk_between(double distance) { return {1, distance, 3, 2.5}; }

/// Capacitance (F) of a sphere in front of a plane: 4 pi eps R sinh(u) sum 1 / sinh(n u), cosh(u) = 1 + distance / R.
double sphere_before_plane(double distance) {
  const double u = std::acosh(1 + distance / radius);
  double sum = 0;
  for (int n = 1; n * u < 40; ++n) sum += 1 / std::sinh(n * u);
  return 4 * pi * permittivity * radius * std::sinh(u) * sum;
}

}  // namespace

TEST_CASE("charge shuttle: monopole_force is Coulomb's law for charges of C V / 2") {
  const SphereShuttle shuttle = shuttle_of(5e-3);
  const double charge = 0.5 * shuttle.capacitance * shuttle.voltage, x = 1.1e-3;
  const auto coulomb = [&](double distance) { return charge * charge / (4 * pi * permittivity * distance * distance); };
  CHECK(monopole_force(shuttle, x) ==
        Approx(coulomb(2.5e-3 - x + 2 * radius) + coulomb(2.5e-3 + x + 2 * radius)).epsilon(1e-13));
}

TEST_CASE("charge shuttle: closed-form crossing time equals numerical integration") {
  for (const double gap : {1e-3, 5e-3, 20e-3}) {
    const SphereShuttle shuttle = shuttle_of(gap);
    const double time =
        overdamped_time([&](double x) { return monopole_force(shuttle, x); }, shuttle.drag, -0.5 * gap, 0.5 * gap);
    // The closed form subtracts terms of a^3: at gap = R it loses 1.5 digits.
    CHECK(crossing_time(shuttle) == Approx(time).epsilon(1e-8));
  }
}

TEST_CASE("charge shuttle: resistance is 2 crossing times / C, proportional to V^-2") {
  SphereShuttle shuttle = shuttle_of(5e-3);
  const double at_18_kv = resistance(shuttle);
  CHECK(at_18_kv == Approx(2 * crossing_time(shuttle) / shuttle.capacitance).epsilon(1e-14));
  shuttle.voltage *= 3;
  CHECK(resistance(shuttle) == Approx(at_18_kv / 9).epsilon(1e-13));
}

TEST_CASE("overdamped and ballistic crossing times: closed forms for linear forces") {
  CHECK(overdamped_time([](double) { return 2.0; }, 3, 1, 5) == Approx(6).epsilon(1e-12));
  CHECK(ballistic_time([](double) { return 2.0; }, 3, 1, 5) == Approx(6).epsilon(1e-12));
  const auto rising = [](double x) { return x; };
  CHECK(overdamped_time(rising, 3, 1, 5) == Approx(3 * std::log(5.0)).epsilon(1e-10));
  CHECK(ballistic_time(rising, 3, 1, 5) == Approx(3 * 16 / 12.0).epsilon(1e-10));
}

TEST_CASE("disk near one of two plates: its charge equals the reciprocity formula") {
  // At a distance of 2000 R, the images in the other plate change the charge by a fraction of (R / H)^2 = 2.5e-7.
  const DiskBetweenPlates disk = disk_between(2000);
  for (const double gap : {0.01, 0.1, 1.0}) {
    const DiskState held = at_potential(disk, -disk.position_at_gap(gap), 0.5 * disk.voltage);
    CHECK(held.charge == Approx(charge_near_plate(disk, gap)).epsilon(1e-6));
  }
  CHECK(charge_near_plate(disk, 0) == Approx(2 * pi * 2.5 * 3 / 2000).epsilon(1e-14));
}

TEST_CASE("disk between plates: a position on or beyond a plate is refused") {
  const DiskBetweenPlates disk = disk_between(4.5);
  for (const double x :
       {disk.position_at_gap(0), -disk.position_at_gap(0), disk.position_at_gap(-0.1), 1e9, std::nan("")}) {
    CHECK_THROWS_AS(with_charge(disk, x, 1), InputError);
    CHECK_THROWS_AS(at_potential(disk, x, 1), InputError);
  }
}

TEST_CASE("disk approaching a plate: repulsion tends to eps R E^2 (pi^3/9 + pi/3)") {
  const DiskBetweenPlates disk = disk_between(2000);
  const auto off = [&](double gap) {
    return at_potential(disk, -disk.position_at_gap(gap), 0.5 * disk.voltage).force / repulsion_at_plate(disk) - 1;
  };
  // The difference is linear in the gap with a coefficient of order one.
  CHECK(std::abs(off(1e-2)) < 1e-2);
  CHECK(std::abs(off(1e-3)) < 1e-3);
}

TEST_CASE("disk near a plate at 0 V: charge and force equal those of a mirror pair") {
  // At a distance of 4e6 R, the other plate changes the potential by a fraction of R / 4e6.
  DiskBetweenPlates disk = disk_between(4e6);
  disk.voltage = 0;
  const double gap = 0.05, potential = 1.5;
  const DiskState held = at_potential(disk, disk.position_at_gap(gap), potential);
  const double exact = 2 * pi * disk.permittivity / std::acosh(1 + gap);
  CHECK(held.charge == Approx(potential * exact).epsilon(1e-6));
  const DiskPair pair = {{{0, 0}, 1}, {{2 * (1 + gap), 0}, 1}, disk.permittivity};
  CHECK(held.force == Approx(force(pair, held.charge).x).epsilon(1e-6));
}

TEST_CASE("disk between plates: with_charge and at_potential agree; mirror symmetry") {
  const DiskBetweenPlates disk = disk_between(4.5);
  const DiskState floating = with_charge(disk, 0.9, -2.0);
  const DiskState held = at_potential(disk, 0.9, floating.potential);
  CHECK(held.charge == Approx(-2.0).epsilon(1e-12));
  CHECK(held.force == Approx(floating.force).epsilon(1e-12));
  const DiskState mirrored = with_charge(disk, -0.9, 2.0);
  CHECK(mirrored.potential == Approx(-floating.potential).epsilon(1e-10));
  CHECK(mirrored.force == Approx(-floating.force).epsilon(1e-10));
}

TEST_CASE("thin disk between distant plates: the force is that of a line charge") {
  // The radius adds terms of the order (R / distance to the plate)^2 of the force, and of E^2 alone.
  const DiskBetweenPlates disk = disk_between(400);
  const double charge = 50 * disk.permittivity * disk.field();
  for (const double x : {-100.0, 0.0, 120.0})
    CHECK(with_charge(disk, x, charge).force == Approx(line_charge_force(disk, charge, x)).epsilon(1e-3));
}

TEST_CASE("two close spheres: half the capacitance of sphere and plane at half gap") {
  const double gap = 1e-4 * radius;
  // Two spheres with a small gap are two planes at half the gap in series. The neglected terms are of the order gap /
  // R.
  CHECK(close_spheres_capacitance(radius, permittivity, gap) ==
        Approx(0.5 * sphere_before_plane(0.5 * gap)).epsilon(1e-4));
  const double voltage = 7, step = 1e-3 * gap;
  const double slope = (close_spheres_capacitance(radius, permittivity, gap + step) -
                        close_spheres_capacitance(radius, permittivity, gap - step)) /
                       (2 * step);
  // The relative error of the difference is (step / gap)^2 / 3.
  CHECK(close_spheres_attraction(radius, permittivity, gap, voltage) ==
        Approx(-0.5 * voltage * voltage * slope).epsilon(1e-6));
}

TEST_CASE("broken wire: tension is the attraction of two spheres with +-C V / 2") {
  const BrokenWire wire = wire_of_d();
  const double gap = 1e-5;
  const double voltage = 0.5 * wire.capacitance * wire.voltage / close_spheres_capacitance(radius, permittivity, gap);
  CHECK(tension(wire, gap) == Approx(close_spheres_attraction(radius, permittivity, gap, voltage)).epsilon(1e-12));
}

TEST_CASE("broken wire: mean transverse force averages over all gap positions") {
  const BrokenWire wire = wire_of_d();
  const double field = 1e5, one = 0.5 * wire.capacitance * wire.voltage * field;
  for (const int i : {1, 13, 20}) {
    double sum = 0;
    for (int left = 0; left <= 25; ++left) sum += i <= left ? one : -one;  // With `left` conductors left of the gap.
    CHECK(mean_transverse_force(wire, i, field) == Approx(sum / 26).epsilon(1e-12));
  }
}

TEST_CASE("broken wire: the displacement balances tension and transverse force") {
  BrokenWire wire = wire_of_d();
  wire.conductors = 2000;
  wire.radius = 40e-3 / 2 / 2001;
  const double field = 1e5, wire_tension = tension(wire, wire.mean_gap());
  const double b = shape_coefficient(wire, field, wire_tension), spacing = wire.length / 2001;
  for (const int i : {1, 500, 1600}) {
    const double x = i * spacing;
    const double slope_change =
        (displacement(wire, b, x + spacing) - 2 * displacement(wire, b, x) + displacement(wire, b, x - spacing)) /
        spacing;
    // Second differences of a cubic are exact. B with the positive sign of D curves along the force.
    CHECK(wire_tension * slope_change == Approx(mean_transverse_force(wire, i, field)).epsilon(1e-6));
  }
}

TEST_CASE("broken wire: largest_displacement equals the maximum on a fine grid") {
  const BrokenWire wire = wire_of_d();
  double largest = 0;
  for (int k = 0; k <= 10000; ++k) largest = std::max(largest, displacement(wire, 3.0, wire.length * k / 10000));
  // A parabola on a grid: an error of 1e-4 squared.
  CHECK(largest_displacement(wire, 3.0) == Approx(largest).epsilon(1e-7));
}

TEST_CASE("broken wire: in critical_field, field force * sin(end angle) = tension") {
  const BrokenWire wire = wire_of_d();
  const double wire_tension = tension(wire, wire.mean_gap());
  for (const double slope : {printed_slope, slope_at_end(wire)}) {
    const double across = 0.5 * wire.capacitance * wire.voltage * critical_field(wire, wire_tension, slope);
    const double steepness = slope * across / wire_tension;
    CHECK(across * steepness / std::sqrt(1 + steepness * steepness) == Approx(wire_tension).epsilon(1e-12));
  }
  const double in_units =
      critical_field(wire, wire_tension, printed_slope) * wire.capacitance * wire.voltage / wire_tension;
  CHECK(in_units == Approx(std::sqrt(2 + std::sqrt(145.0) / 6)).epsilon(1e-14));  // D 4.20
  CHECK(in_units == Approx(2.002).epsilon(5e-4));
}

TEST_CASE("broken wire: the published formula gives a critical field of 19.6 kV/m") {
  CHECK(printed_critical_field(wire_of_d()) == Approx(19.6e3).epsilon(3e-3));  // Computed manually to three digits.
}

TEST_CASE("broken wire: elongation limits the shape coefficient to a maximum") {
  const BrokenWire wire = wire_of_d();
  for (const double p : {1.0, 1.5}) {
    double most = 0;
    for (double b = 0; b < 2000; b += 0.5) {
      double longer = 0;  // Integral of y'^2 / 2 by the midpoint rule.
      const int parts = 200;
      for (int k = 0; k < parts; ++k) {
        const double from = wire.length * k / parts, to = wire.length * (k + 1) / parts;
        const double rise = displacement(wire, b, to) - displacement(wire, b, from);
        longer += 0.5 * rise * rise / (to - from);
      }
      most = std::max(most, b * std::pow(1 + longer / wire.whole_gap(), -p));
    }
    CHECK(largest_shape_coefficient(wire, p) == Approx(most).epsilon(2e-4));  // The relative error is (1/200)^2 of y'.
  }
}

}  // namespace chapter_4_test
