// Tests of dielectric spheres: forces, potentials and dipoles against closed forms and energy derivatives.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "tests/dielectric_pair.hpp"
#include "tests/sphere_problems.hpp"

namespace spheres_dielectric_test {

using namespace lichtenberg;
using namespace lichtenberg::laplace;
using namespace lichtenberg::sphere_problems;

namespace {

SphereProblem two_dielectrics(double k, double gap) {
  return {.free_space = true,
          .permittivity = 1,
          .spheres = {{{0, 0, 1 + gap / 2}, 1, 0, k}, {{0, 0, -1 - gap / 2}, 1, 1, k}},
          .groups = {{.charge = 1}, {.charge = -1}}};
}

}  // namespace

TEST_CASE("two dielectric spheres: attraction as in bispherical coordinates") {
  // At large distances and without polarization the values are Coulomb's.
  CHECK(dielectric_pair(1, 4).attraction == doctest::Approx(1 / (4 * std::numbers::pi * 36)).epsilon(1e-12));
  CHECK(dielectric_pair(1, 4).potential == doctest::Approx(1 / (4 * std::numbers::pi) * (1 - 1 / 6.0)).epsilon(1e-12));
  for (const double accuracy : {1e-3, 1e-5})
    for (const double k : {1.5, 5.0, 20.0})
      for (const double gap : {1.0, 1e-1, 1e-2, 1e-4}) {
        if (accuracy < 1e-4 && k > 10 && gap < 1e-2) continue;  // This case takes more harmonics than are available.
        const BisphericalPair exact = dielectric_pair(k, gap);
        const SphereSolution found = SphereSolver({.accuracy = accuracy}).solve(two_dielectrics(k, gap));
        CHECK(std::abs(found.sphere_force[0].z + exact.attraction) < accuracy * exact.attraction);
        CHECK(found.group_potential[0] == doctest::Approx(exact.potential).epsilon(accuracy));
        CHECK(found.sphere_charge[0] == doctest::Approx(1).epsilon(1e-14));
      }
  // At contact the force is the limit.
  const SphereSolution touching = SphereSolver({.accuracy = 1e-4}).solve(two_dielectrics(5, 0));
  CHECK(-touching.sphere_force[0].z == doctest::Approx(dielectric_pair(5, 1e-6).attraction).epsilon(1e-3));
}

TEST_CASE("dielectric sphere in a uniform field: Clausius-Mossotti dipole") {
  const double k = 3.5;
  SphereProblem problem{.free_space = true, .uniform_field = {0.3, -0.2, 0.5}, .permittivity = 2};
  problem.spheres = {{{0.1, 0.2, 0.3}, 0.7, 0, k}};
  problem.groups = {{.charge = 0.4}};
  const SphereSolution found = SphereSolver({.accuracy = 1e-10}).solve(problem);
  const double polarizability = 4 * std::numbers::pi * 2 * std::pow(0.7, 3) * (k - 1) / (k + 2);
  for (int axis = 0; axis < 3; ++axis) {
    CHECK(found.sphere_dipole[0][axis] == doctest::Approx(polarizability * problem.uniform_field[axis]).epsilon(1e-9));
    CHECK(found.sphere_force[0][axis] == doctest::Approx(0.4 * problem.uniform_field[axis]).epsilon(1e-9));
  }
}

TEST_CASE("dielectric spheres: forces are energy derivatives, eps 1e9 as conductor") {
  SphereProblem problem = mixed_box();
  problem.spheres[0].relative_permittivity = 4;
  for (int axis = 0; axis < 3; ++axis)
    for (const int sphere : {0, 2}) CHECK(std::abs(slope_error(problem, sphere, axis, 2e-3, 1e-10)) < 1e-7);
  SphereSolver solver({.accuracy = 1e-6, .degree = 12});
  problem.spheres[0].relative_permittivity = 1e9;
  const SphereSolution huge = solver.solve(problem);
  problem.spheres[0].relative_permittivity = INFINITY;
  const SphereSolution conductor = solver.solve(problem);
  for (int i = 0; i < 3; ++i)
    CHECK(norm(huge.sphere_force[i] - conductor.sphere_force[i]) < 1e-5 * norm(conductor.sphere_force[1]));
}

// The side at 0 V is the plane of symmetry of two opposite charges in a box of twice the height. Its image overlaps a
// sphere by twice as much as the side.
TEST_CASE("dielectric sphere in a grounded side: force of its image") {
  const auto box = [](double height) {
    SphereProblem problem{.permittivity = 1};
    problem.box.lengths = {6, height, 6};
    problem.box.sides = {};
    problem.box.sides.fill(Boundary::wall);
    problem.box.sides[2] = problem.box.sides[3] = Boundary::electrode;
    return problem;
  };
  const auto add = [](SphereProblem& problem, double y, double charge) {
    const int group = static_cast<int>(problem.groups.size());
    problem.spheres.push_back({{3, y, 3}, 1, group, 4});
    problem.groups.push_back({.charge = charge});
  };
  SphereProblem half = box(8), whole = box(16);
  add(half, 0.996, 1);
  add(whole, 8.996, 1), add(whole, 7.004, -1);
  SphereSolver solver({.accuracy = 1e-6});
  const double force = solver.solve(half).sphere_force[0].y;
  CHECK(force < -0.01);
  CHECK(force == doctest::Approx(solver.solve(whole).sphere_force[0].y).epsilon(1e-5));
  half.spheres[0].centre.y = 0.99;
  CHECK_THROWS_WITH_AS(
      half.check(), "sphere 0 is through the side bottom by 1 % of its radius: at most 0.5 % is allowed", InputError);
}

}  // namespace spheres_dielectric_test
