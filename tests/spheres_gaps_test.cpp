// Tests of gaps between conducting spheres, at one potential or two, down to contact.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "solvers/laplace/spheres/close_pairs.hpp"
#include "solvers/parallel/team.hpp"
#include "tests/sphere_problems.hpp"

namespace spheres_gaps_test {

using namespace lichtenberg;
using namespace lichtenberg::sphere_problems;

TEST_CASE("two spheres: gaps down to 1e-5 R meet the requested accuracy") {
  // Exact C_11, C_12 and force on the second sphere at potentials 1 and 0, by image charges in 40-digit arithmetic. The
  // force is the derivative of the charges.
  struct Exact {
    double other, gap, own, mutual, force;
  };
  for (const Exact& exact : {Exact{1, 1e-2, 26.85019748512267, -18.130584124145314, -155.06556819774652},
                             Exact{1, 1e-4, 41.272931590497859, -32.562494417980659, -15704.742104128324},
                             Exact{0.5, 1e-3, 26.743809171604176, -16.04224220718239, -1044.5408792016476},
                             Exact{0.5, 1e-5, 36.38293526862656, -25.681338479864124, -104715.49027253303}})
    for (const double accuracy : {1e-3, 1e-6, 1e-9}) {
      CAPTURE(exact.gap);
      CAPTURE(accuracy);
      SphereProblem problem{.free_space = true, .permittivity = 1};
      problem.spheres = {{{0, 0, 0}, 1, 0}, {{0, 0, 1 + exact.other + exact.gap}, exact.other, 1}};
      problem.groups = {{.floating = false, .potential = 1}, {.floating = false}};
      const SphereSolution found = SphereSolver({.accuracy = accuracy}).solve(problem);
      // The distance of the centres is rounded by 2e-16, which is 2e-11 of the smallest gap.
      CHECK(std::abs(found.sphere_charge[0] / exact.own - 1) < accuracy);
      CHECK(std::abs(found.sphere_charge[1] / exact.mutual - 1) < accuracy);
      CHECK(std::abs(found.sphere_force[1].z / exact.force - 1) < accuracy);
      CHECK(std::abs(found.sphere_force[0].z / exact.force + 1) < accuracy);
    }
}

/// Compares three spheres, in a row or in a triangle, with harmonics without a close-pair correction: exp(-alpha 200),
/// alpha = acosh(1 + gap/2), is 2e-9 at 0.01 R.
void check_three_spheres(double gap, bool row) {
  CAPTURE(gap);
  CAPTURE(row);
  const double d = 2 + gap;
  const Vec3 third = row ? Vec3{2 * d, 0, 0} : Vec3{0.5 * d, std::sqrt(0.75) * d, 0};
  SphereProblem problem{.free_space = true, .permittivity = 1};
  problem.spheres = {{{0, 0, 0}, 1, 0}, {{d, 0, 0}, 1, 1}, {third, 1, 2}};
  problem.groups = {{.floating = false, .potential = -1}, {.charge = 15}, {.charge = 0}};
  const SphereSolution exact = SphereSolver({.accuracy = 1e-10, .degree = 200}).solve(problem);
  for (const double accuracy : {1e-2, 1e-3, 1e-4, 1e-6}) {
    CAPTURE(accuracy);
    const SphereSolution found = SphereSolver({.accuracy = accuracy}).solve(problem);
    for (int i = 0; i < 3; ++i) {
      CHECK(std::abs(found.group_potential[i] - exact.group_potential[i]) < accuracy);
      // The error is linear in the truncation at each gap of a sphere, and there are two gaps.
      CHECK(norm(found.sphere_force[i] - exact.sphere_force[i]) < 2 * accuracy * norm(exact.sphere_force[0]));
    }
  }
}

TEST_CASE("three spheres in a row, gaps of 0.03 R: errors within twice the request") {
  check_three_spheres(0.03, true);
}

TEST_CASE("three spheres, gaps of 0.01 to 0.1 R: errors as requested" * doctest::test_suite("long")) {
  for (const double gap : {0.1, 0.03, 0.01})
    for (const bool row : {true, false}) check_three_spheres(gap, row);
}

TEST_CASE("three spheres with gaps of 1e-4 R: accurate as requested") {
  const double gap = 1e-4;
  SphereProblem problem{.free_space = true, .permittivity = 1};
  for (int i = 0; i < 3; ++i) problem.spheres.push_back({{i * (2 + gap), 0, 0}, 1, i});
  problem.groups = {{.floating = false, .potential = -1}, {.charge = 15}, {.charge = 0}};
  const SphereSolution exact = SphereSolver({.accuracy = 1e-9}).solve(problem);
  for (const double accuracy : {1e-3, 1e-6}) {
    CAPTURE(accuracy);
    const SphereSolution found = SphereSolver({.accuracy = accuracy}).solve(problem);
    for (int i = 0; i < 3; ++i) {
      CHECK(std::abs(found.group_potential[i] - exact.group_potential[i]) < accuracy);
      CHECK(norm(found.sphere_force[i] - exact.sphere_force[i]) < accuracy * norm(exact.sphere_force[0]));
    }
  }
}

TEST_CASE("four spheres in a bent row: two close-pair corrections keep the accuracy") {
  // The second and the fourth sphere have a gap of 0.09. Harmonics (2 / 2.09)^(2l) of both close-pair corrections count
  // up to degree 100.
  const double gap = 1e-4, d = 2 + gap, wide = 2.09, turn = std::numbers::pi / 3 + std::acos(wide / (2 * d));
  SphereProblem problem{.free_space = true, .permittivity = 1};
  problem.spheres = {{{-d, 0, 0}, 1, 0},
                     {{0, 0, 0}, 1, 1},
                     {{0.5 * d, std::sqrt(0.75) * d, 0}, 1, 2},
                     {{wide * std::cos(turn), wide * std::sin(turn), 0}, 1, 3}};
  problem.groups = {
      {.floating = false, .potential = 70}, {.charge = 40}, {.charge = 40}, {.floating = false, .potential = -100}};
  const SphereSolution exact = SphereSolver({.accuracy = 1e-7}).solve(problem);
  double largest = 0;
  for (const Vec3 force : exact.sphere_force) largest = std::max(largest, norm(force));
  for (const double accuracy : {1e-2, 1e-3, 1e-4}) {
    CAPTURE(accuracy);
    const SphereSolution found = SphereSolver({.accuracy = accuracy}).solve(problem);
    for (int i = 0; i < 4; ++i) {
      CHECK(std::abs(found.group_potential[i] - exact.group_potential[i]) < 170 * accuracy);
      CHECK(norm(found.sphere_force[i] - exact.sphere_force[i]) < accuracy * largest);
    }
  }
}

/// Returns unit spheres in a row of a general direction, at potentials 1, 0, 1 and -1.
SphereProblem row_of_four(double gap) {
  SphereProblem problem{.free_space = true, .permittivity = 1};
  for (int i = 0; i < 4; ++i) {
    problem.spheres.push_back({Vec3{0.36, 0.48, 0.8} * (i * (2 + gap)), 1, i});
    problem.groups.push_back({.floating = false, .potential = std::array{1.0, 0.0, 1.0, -1.0}[i]});
  }
  return problem;
}

TEST_CASE("row of four spheres: force on the last is that of axial multipoles") {
  // The axial multipoles of all spheres as one dense system, up to degree 130, 340 and 1000.
  for (const auto& [gap, charge, force] : {std::array{0.1, -31.286106934827725, -58.105079555791676},
                                           std::array{1e-2, -45.24724370881672, -621.15787278122923},
                                           std::array{1e-3, -59.64232294720802, -6273.6095859796615}})
    for (const double accuracy : {1e-2, 1e-6, 1e-10}) {
      CAPTURE(gap);
      CAPTURE(accuracy);
      const SphereSolution found = SphereSolver({.accuracy = accuracy}).solve(row_of_four(gap));
      CHECK(std::abs(found.sphere_charge[3] / charge - 1) < accuracy);
      CHECK(std::abs(dot(found.sphere_force[3], {0.36, 0.48, 0.8}) / force - 1) < accuracy);
    }
}

TEST_CASE("row of four spheres, gaps of 1.5e-5 R: accurate as requested") {
  // Corrections on the far sides of a gap interact up to a degree of thousands.
  const SphereProblem problem = row_of_four(1.5e-5);
  const SphereSolution exact = SphereSolver({.accuracy = 1e-9}).solve(problem);
  for (const double accuracy : {1e-4, 1e-6}) {
    CAPTURE(accuracy);
    const SphereSolution found = SphereSolver({.accuracy = accuracy}).solve(problem);
    for (int i = 0; i < 4; ++i) {
      CHECK(std::abs(found.sphere_charge[i] - exact.sphere_charge[i]) < accuracy * std::abs(exact.sphere_charge[3]));
      CHECK(norm(found.sphere_force[i] - exact.sphere_force[i]) < accuracy * norm(exact.sphere_force[3]));
    }
  }
}

TEST_CASE("neutral sphere near an electrode: force in a gap of 1e-5 R is accurate") {
  SphereProblem problem{.permittivity = 1};
  problem.box.lengths = {20, 20, 20};
  problem.box.sides[4] = Boundary::electrode;
  const double gap = 1e-5;
  problem.spheres = {{{8, 9, 12}, 1, 0}, {{12, 11, 1 + gap}, 1, 1}};
  problem.groups = {{.floating = false, .potential = 100}, {.charge = 0}};
  const SphereSolution exact = SphereSolver({.accuracy = 1e-8}).solve(problem);
  // The gap dominates the force: a difference dV gives about pi eps R dV^2 / gap, larger than any other force here.
  CHECK(norm(exact.sphere_force[1]) > norm(exact.sphere_force[0]));
  for (const double accuracy : {1e-2, 1e-3, 1e-4})
    CHECK(norm(SphereSolver({.accuracy = accuracy}).solve(problem).sphere_force[1] - exact.sphere_force[1]) <
          accuracy * norm(exact.sphere_force[1]));
}

TEST_CASE("close-pair correction of spheres: threads give identical bits") {
  SphereProblem problem{.free_space = true, .permittivity = 1};
  for (int i = 0; i < 12; ++i) {
    problem.spheres.push_back({{2.01 * (i % 4), 2.01 * (i / 4), 0.3 * (i % 3)}, 1 - 0.02 * (i % 2), i});
    problem.groups.push_back({.charge = i % 2 ? 1.0 : -2.0});
  }
  parallel::Team team(3);
  const SphereSolution alone = SphereSolver({.accuracy = 1e-3}).solve(problem),
                       together = SphereSolver({.accuracy = 1e-3}, team).solve(problem);
  CHECK(alone.group_potential == together.group_potential);
  for (int i = 0; i < 12; ++i) CHECK(alone.sphere_force[i] == together.sphere_force[i]);
}

/// Returns a box with a gap above an electrode and one between two spheres.
SphereProblem box_with_gaps(double gap) {
  SphereProblem problem = mixed_box();
  problem.spheres[0].centre.z = 0.15 + gap;  // Above an electrode.
  problem.spheres[2].centre = problem.spheres[1].centre + Vec3{0.6, -0.48, 0.64} * (0.32 + gap);
  problem.groups[2] = {.floating = false, .potential = -1};
  return problem;
}

/// Compares a force with the energy's derivative: fourth order in step / gap = 0.05, with a fifth derivative of about
/// 24 forces: 6e-6 of the force.
void check_slope(const SphereProblem& problem, const SphereSolution& found, int sphere, int axis, double gap) {
  CAPTURE(sphere);
  CAPTURE(axis);
  CHECK(std::abs(slope_error(problem, sphere, axis, 0.05 * gap, 1e-9)) < 1e-5 * norm(found.sphere_force[sphere]));
}

TEST_CASE("spheres with gaps of 1e-3: forces are energy derivatives" * doctest::test_suite("long")) {
  const SphereProblem problem = box_with_gaps(1e-3);
  const SphereSolution found = SphereSolver({.accuracy = 1e-9}).solve(problem);
  for (const int sphere : {0, 2})
    for (int axis = 0; axis < 3; ++axis) check_slope(problem, found, sphere, axis, 1e-3);
}

TEST_CASE("spheres with gaps of 1e-3: force is energy derivative, field is dV/gap") {
  const double gap = 1e-3;
  const SphereProblem problem = box_with_gaps(gap);
  const SphereSolution found = SphereSolver({.accuracy = 1e-9}).solve(problem);
  check_slope(problem, found, 2, 0, gap);
  // In the middle of a gap between curved surfaces the field is the difference over the gap, within gap / R.
  const Vec3 middle = problem.spheres[1].centre + Vec3{0.6, -0.48, 0.64} * (0.2 + 0.5 * gap);
  SphereSolver rough({.accuracy = 1e-3});  // At this low degree the close-pair correction dominates the field.
  rough.solve(problem);
  const PointField between = rough.field(std::vector<Vec3>{middle})[0];
  CHECK(dot(between.field, {0.6, -0.48, 0.64}) == doctest::Approx(1.3 / gap).epsilon(0.02));
  CHECK(between.potential == doctest::Approx(-0.35).epsilon(0.02));
  const PointField below = rough.field(std::vector<Vec3>{{0.1, 0.3, 0.5 * gap}})[0];
  CHECK(below.field.z == doctest::Approx((1 - found.group_potential[0]) / gap).epsilon(0.02));
}

TEST_CASE("touching spheres at one potential: Maxwell's charge, Kelvin's force") {
  // Two equal spheres in contact have the capacitance 8 pi eps R ln 2 (Maxwell).
  SphereProblem pair{.free_space = true, .permittivity = 1};
  pair.spheres = {{{0, 0, 0}, 1, 0}, {{1.2, 0, 1.6}, 1, 0}};
  pair.groups = {{.floating = false, .potential = 1}};
  const SphereSolution touching = SphereSolver({.accuracy = 1e-9}).solve(pair);
  CHECK(touching.sphere_charge[0] + touching.sphere_charge[1] ==
        doctest::Approx(8 * std::numbers::pi * std::log(2.0)).epsilon(1e-9));
  // Two spheres at potential 1 repel each other with 4 pi eps R^2 E^2 (ln 2 - 1/4) / 6 (Kelvin).
  CHECK(touching.sphere_force[1].x ==
        doctest::Approx(0.6 * 4 * std::numbers::pi * (std::log(2.0) - 0.25) / 6).epsilon(1e-8));
  // A sphere on an insulating side is half of such a pair.
  SphereProblem lying{.permittivity = 1};
  lying.box.lengths = {1, 1, 1};
  lying.box.sides[5] = Boundary::electrode;
  lying.spheres = {{{0.4, 0.5, 0.1}, 0.1, 0}};
  lying.groups = {{.charge = 1}};
  SphereProblem both = lying;
  both.box.lengths.z = 2;
  both.box.sides[4] = Boundary::electrode;
  both.spheres = {{{0.4, 0.5, 1.1}, 0.1, 0}, {{0.4, 0.5, 0.9}, 0.1, 0}};
  both.groups = {{.charge = 2}};
  const SphereSolution one = SphereSolver({.accuracy = 1e-9}).solve(lying),
                       two = SphereSolver({.accuracy = 1e-9}).solve(both);
  CHECK(one.group_potential[0] == doctest::Approx(two.group_potential[0]).epsilon(1e-9));
  CHECK(one.sphere_force[0].z == doctest::Approx(two.sphere_force[0].z).epsilon(1e-8));
}

/// Compares the energy of the corrections of equal spheres at a tolerance with that at 1e-8.
void check_energy(double gap, int degree, double tolerance) {
  CAPTURE(gap);
  const std::vector<spheres::Site> sites{{{0, 0, 0}, 1, degree}, {{0, 0, 2 + gap}, 1, degree}};
  const std::vector<spheres::NearPair> pair{{0, 1, 0, 1, {0, 0, -2 - gap}}};
  const double rough = spheres::close_pairs(sites, pair, tolerance).at(0).energy;
  CHECK(rough == doctest::Approx(spheres::close_pairs(sites, pair, 1e-8).at(0).energy).epsilon(0.1));
}

TEST_CASE("close_pairs: energy at tolerances 0.03, 0.05 within 10 % of 1e-8") {
  for (const double gap : {0.05, 0.1, 0.2, 0.3, 0.4})
    check_energy(gap, static_cast<int>(-std::log(0.04) / spheres::bispherical_coordinate(1, 1, gap)), 0.03);
  for (const double gap : {1.0, 1.5, 2.0}) check_energy(gap, 2, 0.05);  // Energies are far below the squared tolerance
}

}  // namespace spheres_gaps_test
