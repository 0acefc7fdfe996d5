// Conducting spheres in space: reference solutions, symmetries of the operator, forces as slopes of the energy.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "solvers/error.hpp"
#include "solvers/laplace/spheres/translation.hpp"
#include "tests/sphere_references.hpp"

using namespace lichtenberg;
using namespace lichtenberg::laplace;

namespace {

/// A box with an electrode at the bottom and the top, periodic along x, and insulating along y.
SphereProblem mixed_box() {
  SphereProblem problem{.permittivity = 2};
  problem.box.lengths = {1.0, 0.9, 1.1};
  problem.box.sides = {Boundary::periodic, Boundary::periodic,  Boundary::wall,
                       Boundary::wall,     Boundary::electrode, Boundary::electrode};
  problem.side_potential[4] = 1, problem.side_potential[5] = -0.5;
  problem.spheres = {{{0.1, 0.3, 0.4}, 0.15, 0}, {{0.5, 0.6, 0.7}, 0.2, 1}, {{0.9, 0.35, 0.75}, 0.12, 2}};
  problem.groups = {{.charge = 1}, {.floating = false, .potential = 0.3}, {.charge = -0.7}};
  return problem;
}

/// What is constant along a path at given charges and given potentials: the energy less what sources of fixed potential
/// put in.
double free_energy(const SphereProblem& problem, const SphereSolution& solution) {
  double energy = solution.energy;
  for (std::size_t i = 0; i < problem.spheres.size(); ++i) {
    const Group& group = problem.groups[problem.spheres[i].group];
    if (!group.floating) energy -= solution.sphere_charge[i] * group.potential;
  }
  for (int side = 0; side < 6; ++side) energy -= solution.side_charge[side] * problem.side_potential[side];
  return energy;
}

double slope_error(const SphereProblem& problem, int sphere, int axis) {
  const double step = 1e-4;
  SphereSolver solver({.accuracy = 1e-11});
  const double force = solver.solve(problem).sphere_force[sphere][axis];
  const auto at_distance = [&](double distance) {
    SphereProblem moved = problem;
    moved.spheres[sphere].centre[axis] += distance;
    return free_energy(moved, solver.solve(moved));
  };
  const double slope =
      (8 * (at_distance(step) - at_distance(-step)) - (at_distance(2 * step) - at_distance(-2 * step))) / (12 * step);
  return force + slope;
}

}  // namespace

TEST_CASE("reference solutions come out to ten digits") {
  for (const sphere_references::SphereReference& reference : sphere_references::read_all_spheres()) {
    CAPTURE(reference.name);
    CHECK(sphere_references::errors_of(reference, 1e-10).worst() < 1e-10);
  }
}

TEST_CASE("multipoles moved to another centre make the same field there") {
  constexpr int source_degree = 6, target_degree = 60;
  const laplace::spheres::Translation translation(target_degree);
  using laplace::spheres::at;
  using laplace::spheres::harmonics;
  const Vec3 way{1.1, -1.7, 0.6}, offset{0.1, 0.2, -0.25};
  const double d = norm(way), source_radius = 0.5, target_radius = 0.4;
  std::vector<laplace::spheres::Lanes> value(harmonics(target_degree)), scratch(value.size());
  std::vector<double> near(value.size()), there(value.size());
  laplace::spheres::regular_harmonics(offset, target_degree, near.data());
  laplace::spheres::regular_harmonics(way + offset, source_degree, there.data());
  laplace::spheres::Ways ways;
  for (int lane = 0; lane < laplace::spheres::lanes; ++lane) ways.set(lane, way);
  double exact = 0;
  for (int l = 0; l <= source_degree; ++l)
    for (int m = -l; m <= l; ++m) {
      const double a = std::sin(1.0 + 7 * l + 3 * m);
      value[at(l, m)] = laplace::spheres::Lanes{} + a * std::pow(2 * source_radius / d, l) * source_radius / d;
      exact += a * there[at(l, m)] * std::pow(source_radius, l + 1) / std::pow(norm(way + offset), 2 * l + 1);
    }
  translation.apply(ways, source_degree, target_degree, value.data(), scratch.data());
  double moved = 0;
  for (int l = 0; l <= target_degree; ++l)
    for (int m = -l; m <= l; ++m)
      moved += value[at(l, m)][3] * std::pow(2 * target_radius / d, l) * near[at(l, m)] / std::pow(target_radius, l);
  // |offset| / |way| = 0.16 to the power 60 is nothing; rounding of sums of some thousand terms.
  CHECK(moved == doctest::Approx(exact).epsilon(1e-13));
}

TEST_CASE("a force is the slope of the energy, at given charges and at given potentials") {
  // Central differences of fourth order: h^4 times the fifth derivative, some 1/(0.15)^5 of the force, is 1e-11 of it;
  // rounding, 1e-12 of the energy over the step, 1e-8.
  for (int sphere = 0; sphere < 3; ++sphere)
    for (int axis = 0; axis < 3; ++axis) {
      CAPTURE(sphere);
      CAPTURE(axis);
      CHECK(std::abs(slope_error(mixed_box(), sphere, axis)) < 1e-7);
    }
}

TEST_CASE("action and reaction are equal in free space") {
  SphereProblem problem{.free_space = true, .permittivity = 1};
  problem.spheres = {{{0, 0, 0}, 1, 0}, {{2.3, 0.2, 0.1}, 0.8, 1}, {{0.4, 2.1, -0.7}, 0.6, 2}};
  problem.groups = {{.charge = 1}, {.floating = false, .potential = -0.2}, {.charge = 3}};
  Vec3 sum;
  for (const Vec3 force : SphereSolver({.accuracy = 1e-11}).solve(problem).sphere_force) sum += force;
  CHECK(norm(sum) < 1e-10);
}

TEST_CASE("what charge there is ends on the electrodes, and nowhere else") {
  const SphereProblem problem = mixed_box();
  const SphereSolution solution = SphereSolver({.accuracy = 1e-11}).solve(problem);
  double sum = 0;
  for (const double q : solution.sphere_charge) sum += q;
  for (const double q : solution.side_charge) sum += q;
  CHECK(std::abs(sum) < 1e-11);
}

TEST_CASE("nothing grounded: charges have to add up, and potentials have zero mean or follow the fixed one") {
  SphereProblem problem{.permittivity = 1};
  problem.box.lengths = {1, 1, 1};
  problem.spheres = {{{0.3, 0.3, 0.3}, 0.1, 0}, {{0.7, 0.6, 0.6}, 0.15, 1}};
  problem.groups = {{.charge = 1}, {.charge = 1}};
  CHECK_THROWS_AS(SphereSolver().solve(problem), InputError);
  problem.groups[1].charge = -1;
  SphereSolver solver({.accuracy = 1e-10});
  const SphereSolution floating = solver.solve(problem);
  CHECK(floating.group_potential[0] == doctest::Approx(-floating.group_potential[1]).epsilon(1e-12));
  problem.groups[1] = {.floating = false, .potential = 5};
  const SphereSolution fixed = solver.solve(problem);
  CHECK(fixed.group_potential[0] - 5 ==
        doctest::Approx(floating.group_potential[0] - floating.group_potential[1]).epsilon(1e-9));
  CHECK(fixed.sphere_charge[1] == doctest::Approx(-1).epsilon(1e-12));
}

TEST_CASE("what is no problem is refused") {
  SphereProblem problem = mixed_box();
  problem.spheres[0].centre.z = 0.14;
  CHECK_THROWS_WITH_AS(problem.check(),
                       "sphere 0 is on or through the side front: its centre is 0.14 m from it, its radius 0.15 m",
                       InputError);
  problem = mixed_box();
  problem.spheres[0].centre = {0.5, 0.6, 0.4};
  CHECK_THROWS_WITH_AS(problem.check(), "spheres 0 and 1 touch, but belong to different groups", InputError);
  problem = mixed_box();
  problem.box.sides[1] = Boundary::wall;
  CHECK_THROWS_AS(problem.check(), InputError);
}
