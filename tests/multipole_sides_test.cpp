// Tests of electrode and insulating sides of the box, and of disks that touch or cross them.
#include <doctest/doctest.h>

#include <cmath>

#include "solvers/laplace/multipole/solver.hpp"
#include "tests/multipole_problems.hpp"

namespace multipole_sides_test {

using namespace lichtenberg;
using namespace lichtenberg::laplace;
using namespace lichtenberg::multipole_problems;

TEST_CASE("disk touching a side of its own potential: solution is continuous") {
  // With an insulating side the problem is half of the plane with a touching image: all values are half. At an
  // electrode of the disk's own potential the solution is continuous in the gap.
  for (const Side::Kind kind : {Side::Kind::insulating, Side::Kind::electrode}) {
    std::vector<double> potential, charge;
    for (const double gap : {1e-9, 0.0, -1e-9}) {
      LaplaceProblem problem{.permittivity = 1};
      problem.size = {3, 2};
      problem.sides[left].kind = kind;
      problem.sides[right].kind = Side::Kind::electrode;
      problem.bodies = {{Disk{{0.5 + gap, 1.1}, 0.5}, 0}, {Disk{{2, 0.7}, 0.3}, 1}};
      problem.groups = {{kind == Side::Kind::insulating, 1, 0}, {true, -2, 0}};
      const LaplaceSolution solution = MultipoleSolver(options(1e-10)).solve(problem);
      potential.push_back(solution.group_potential[1]);
      charge.push_back(solution.body_charge[0]);
    }
    for (const int k : {1, 2}) {
      CHECK(potential[k] == doctest::Approx(potential[0]).epsilon(1e-8));
      CHECK(charge[k] == doctest::Approx(charge[0]).epsilon(1e-8));
    }
  }
}

TEST_CASE("disk near an electrode side: equals the pair with its mirror image") {
  for (const double gap : {0.3, 1e-2, 1e-5}) {
    CAPTURE(gap);
    LaplaceProblem near_side{.permittivity = 1};
    near_side.size = {3, 2};
    near_side.sides[top] = {Side::Kind::electrode, 0.25, {}};
    near_side.bodies = {{Disk{{1, 2 - 0.4 - gap}, 0.4}, 0}, {Disk{{2.2, 0.8}, 0.3}, 1}};
    near_side.groups = {{true, 1.3, 0}, {false, 0, 1}};
    LaplaceProblem doubled = near_side;  // Mirrored upwards; the potentials are opposite relative to the side's.
    doubled.size.y = 4;
    doubled.sides[top].kind = Side::Kind::insulating;
    doubled.bodies.push_back({Disk{{1, 2 + 0.4 + gap}, 0.4}, 2});
    doubled.bodies.push_back({Disk{{2.2, 3.2}, 0.3}, 3});
    doubled.groups[1].potential = 0.75;
    doubled.groups.push_back({true, -1.3, 0});
    doubled.groups.push_back({false, 0, -0.75});
    MultipoleSolver solver(options(1e-11));
    const LaplaceSolution a = solver.solve(near_side);
    solver.forget();
    const LaplaceSolution b = solver.solve(doubled);
    CHECK(a.group_potential[0] == doctest::Approx(b.group_potential[0] + 0.25).epsilon(1e-9));
    CHECK(a.body_charge[1] == doctest::Approx(b.body_charge[1]).epsilon(1e-9));
    CHECK(a.side_charge[top] == doctest::Approx(-1.3 - b.body_charge[1]).epsilon(1e-9));
    // The gap is accurate to 4e-16, and the force goes with its square root.
    for (int k : {0, 1}) {
      CHECK(a.body_force[k].x == doctest::Approx(b.body_force[k].x).epsilon(1e-8));
      CHECK(a.body_force[k].y == doctest::Approx(b.body_force[k].y).epsilon(1e-8));
    }
  }
}

TEST_CASE("multipole boundary conditions: hold on all sides for any electrodes") {
  LaplaceProblem problem = random_disks(6, {1.3, 0.9}, 0.08, 0.03);
  neutralize(problem);
  problem.groups[0] = {false, 0, 0.3};
  const std::array<double, 4> potential{0.2, -0.5, 1, 0.7};
  for (int walls = 0; walls < 16; ++walls) {
    CAPTURE(walls);
    LaplaceProblem walled = problem;
    set_walls(walled, walls, potential);
    MultipoleSolver solver(options(1e-11));
    solver.solve(walled);
    // Into the box from three points of each side. At an insulating side V grows with the square of the distance: 1e-8
    // times a second derivative of about 100. With a slope of 1 it would grow by 1e-4.
    constexpr double step = 1e-4, slack = 1e-5;
    for (const double t : {0.1, 0.45, 0.8}) {
      const std::array<Vec2, 4> on{Vec2{0, 0.9 * t}, {1.3, 0.9 * t}, {1.3 * t, 0}, {1.3 * t, 0.9}};
      const std::array<Vec2, 4> into{Vec2{step, 0}, {-step, 0}, {0, step}, {0, -step}};
      for (int s = 0; s < 4; ++s) {
        if (walls >> s & 1)
          CHECK(solver.potential(on[s]) == doctest::Approx(potential[s]).epsilon(1e-9));
        else
          CHECK(std::abs(solver.potential(on[s] + into[s]) - solver.potential(on[s])) < slack);
      }
    }
  }
}

TEST_CASE("multipole method: charges of disks and sides sum to zero") {
  LaplaceProblem problem = random_disks(5, {1, 1.4}, 0.07, 0.05);
  problem.permittivity = 2.5;
  problem.groups[1] = {false, 0, -0.4};
  for (const int walls : {1, 2, 4, 8, 3, 12, 5, 7, 15}) {
    CAPTURE(walls);
    LaplaceProblem walled = problem;
    // Different potentials only on sides without common corners: left and right alone, or bottom and top alone.
    const bool plates = walls == 3 || walls == 12;
    set_walls(walled, walls, plates ? std::array<double, 4>{0, 3, 1, -1} : std::array<double, 4>{2, 2, 2, 2});
    MultipoleSolver solver(options(1e-11));
    const LaplaceSolution solution = solver.solve(walled);
    CHECK(std::abs(total_charge(solution)) < 1e-9);
    if (plates) CHECK(std::isfinite(solution.energy));
  }
}

TEST_CASE("multipole method, empty box with two plates: it is a plate capacitor") {
  LaplaceProblem problem;
  problem.size = {2, 3};
  problem.permittivity = 5;
  set_walls(problem, 3, {1, 5, 0, 0});
  MultipoleSolver solver(options(1e-10));
  const LaplaceSolution solution = solver.solve(problem);
  // Q = eps V Ly / Lx = 5 * 4 * 3 / 2; W = Q V / 2.
  CHECK(solution.side_charge[right] == doctest::Approx(30));
  CHECK(solution.side_charge[left] == doctest::Approx(-30));
  CHECK(solution.energy == doctest::Approx(60));
  CHECK(solver.potential({0.5, 1}) == doctest::Approx(2));
}

TEST_CASE("corner of different electrodes: side charges infinite, potential exact") {
  // Four sides, one at 1 V. The sum of the four problems rotated by 90 degrees is 1 V everywhere, so an uncharged disk
  // in the middle of a square is at 1/4 V.
  for (int s = 0; s < 4; ++s) {
    LaplaceProblem problem{.permittivity = 1};
    problem.size = {1, 1};
    std::array<double, 4> potential{};
    potential[s] = 1;
    set_walls(problem, 15, potential);
    problem.bodies = {{Disk{{0.5, 0.5}, 0.2}, 0}};
    problem.groups = {{true, 0, 0}};
    MultipoleSolver solver(options(1e-12));
    const LaplaceSolution solution = solver.solve(problem);
    CHECK(solution.group_potential[0] == doctest::Approx(0.25).epsilon(1e-11));
    CHECK(solution.energy == INFINITY);
    CHECK(solution.side_charge[s] == INFINITY);
    const int opposite = s ^ 1, beside = s ^ 2;
    CHECK(solution.side_charge[beside] == -INFINITY);
    CHECK(std::isfinite(solution.side_charge[opposite]));
  }
}

TEST_CASE("disk near a corner of different electrodes: potential exact to 1e-11") {
  // The corner is at a distance of 2.5 R: there the field has a pole, 0.4^k at order k. The images, at 5 R and more,
  // need a series of about 0.2^k.
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {1, 1};
  set_walls(problem, 5, {1, 0, 0, 0});
  problem.bodies = {{Disk{{0.3, 0}, 0.12}, 0}};
  problem.groups = {{false, 0, 0}};
  MultipoleSolver solver(options(1e-11));
  solver.solve(problem);
  for (int k = 1; k < 50; ++k) {
    const double theta = pi * k / 50;
    const Vec2 p = Vec2{0.3, 0} + (1 + 1e-14) * 0.12 * Vec2{std::cos(theta), std::sin(theta)};
    CHECK(std::abs(solver.potential(p)) < 1e-11);
  }
}

TEST_CASE("half-disks on insulating sides: half the values of the mirrored scene") {
  // The lower box mirrored upwards has a whole disk and two of each other disk. All values of the half are half. The
  // force on the half lacks the mirror's cancelling part.
  LaplaceProblem half{.permittivity = 1};
  half.size = {1, 0.6};
  half.sides[left].kind = Side::Kind::electrode;
  half.bodies = {{Disk{{0.4, 0.6}, 0.15}, 0}, {Disk{{0.62, 0.4}, 0.1}, 1}, {Disk{{1, 0.2}, 0.12}, 2}};
  half.groups = {{true, 0.7, 0}, {true, -1.1, 0}, {false, 0, 0.3}};
  LaplaceProblem whole = half;
  whole.size = {1, 1.2};
  whole.bodies.push_back({Disk{{0.62, 0.8}, 0.1}, 3});
  whole.bodies.push_back({Disk{{1, 1}, 0.12}, 2});
  whole.groups[0].charge = 1.4;
  whole.groups.push_back({true, -1.1, 0});
  MultipoleSolver solver(options(1e-11));
  const LaplaceSolution a = solver.solve(half), b = solver.solve(whole);
  for (int g = 0; g < 3; ++g) CHECK(a.group_potential[g] == doctest::Approx(b.group_potential[g]).epsilon(1e-10));
  CHECK(a.body_charge[2] == doctest::Approx(b.body_charge[2]).epsilon(1e-10));
  CHECK(a.body_force[0].x == doctest::Approx(0.5 * b.body_force[0].x).epsilon(1e-9));
  CHECK(a.body_force[1].y == doctest::Approx(b.body_force[1].y).epsilon(1e-9));
  CHECK(a.side_charge[left] == doctest::Approx(0.5 * b.side_charge[left]).epsilon(1e-9));
  CHECK(a.energy == doctest::Approx(0.5 * b.energy).epsilon(1e-10));
}

TEST_CASE("quarter-disks in corners: values follow from the mirrored scene") {
  // Insulating left and bottom sides: the scene is mirrored in both. With an electrode on the left the quarter has its
  // potential, and the mirrored scene has the opposite potentials.
  for (const bool electrode : {false, true}) {
    LaplaceProblem quarter{.permittivity = 1};
    quarter.size = {1, 1};
    quarter.bodies = {{Disk{{0, 0}, 0.2}, 0}, {Disk{{0.4, 0.3}, 0.15}, 1}};
    quarter.groups = {{false, 0, 0}, {true, 1, 0}};
    quarter.sides[top].kind = Side::Kind::electrode;
    if (electrode) quarter.sides[left].kind = Side::Kind::electrode;
    LaplaceProblem half{.permittivity = 1};  // Mirrored in the left side only, and shifted by 1.
    half.size = {2, 1};
    half.sides[top].kind = Side::Kind::electrode;
    half.bodies = {{Disk{{1, 0}, 0.2}, 0}, {Disk{{1.4, 0.3}, 0.15}, 1}, {Disk{{0.6, 0.3}, 0.15}, 2}};
    half.groups = {{false, 0, 0}, {true, 1, 0}, {true, electrode ? -1.0 : 1.0, 0}};
    MultipoleSolver solver(options(1e-11));
    const LaplaceSolution a = solver.solve(quarter), b = solver.solve(half);
    CHECK(a.group_potential[1] == doctest::Approx(b.group_potential[1]).epsilon(1e-10));
    CHECK(a.body_force[1].x == doctest::Approx(b.body_force[1].x).epsilon(1e-9));
    CHECK(a.body_force[0].y == doctest::Approx(0.5 * b.body_force[0].y).epsilon(1e-9));
    if (!electrode) CHECK(a.body_charge[0] == doctest::Approx(0.5 * b.body_charge[0]).epsilon(1e-9));
    CHECK(std::abs(total_charge(a)) < 1e-10);
  }
}

TEST_CASE("half-disk on a side: charge and force are integrals over its arc") {
  for (const bool electrode : {false, true}) {
    LaplaceProblem problem{.permittivity = 1};
    problem.size = {1, 1};
    problem.sides[bottom] = {electrode ? Side::Kind::electrode : Side::Kind::insulating, electrode ? 0.5 : 0.0, {}};
    const Disk disk{{0.45, 0}, 0.2};
    problem.bodies = {{disk, 0}, {Disk{{0.6, 0.35}, 0.1}, 1}};
    problem.groups = {{false, 0, 0.5}, {true, 1, 0}};
    MultipoleSolver solver(options(1e-12));
    const LaplaceSolution solution = solver.solve(problem);
    // E_n from fourth-order differences over 1e-3 has an error of about 1e-12 V'''''. Simpson's rule with 400 intervals
    // has 1e-8.
    const auto normal_field = [&](double theta) {
      const Vec2 n{std::cos(theta), std::sin(theta)};
      const double h = 1e-3;
      const auto v = [&](double r) { return solver.potential(disk.centre + (disk.radius + r) * n); };
      return -(-25 * 0.5 + 48 * v(h) - 36 * v(2 * h) + 16 * v(3 * h) - 3 * v(4 * h)) / (12 * h);
    };
    constexpr int intervals = 400;
    double charge = 0;
    Vec2 force;
    for (int k = 0; k <= intervals; ++k) {
      const double theta = pi * k / intervals, e = normal_field(theta);
      const double weight = (k == 0 || k == intervals ? 1 : k % 2 == 1 ? 4 : 2) * pi / intervals / 3 * disk.radius;
      charge += weight * e;
      force += weight * 0.5 * e * e * Vec2{std::cos(theta), std::sin(theta)};
    }
    CHECK(solution.body_charge[0] == doctest::Approx(charge).epsilon(1e-6));
    CHECK(solution.body_force[0].x == doctest::Approx(force.x).epsilon(1e-6));
    CHECK(solution.body_force[0].y == doctest::Approx(force.y).epsilon(1e-6));
    CHECK(std::abs(total_charge(solution)) < 1e-11);
  }
}

}  // namespace multipole_sides_test
