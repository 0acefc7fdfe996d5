#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "solvers/error.hpp"
#include "solvers/laplace/spheres/accuracy.hpp"

namespace spheres_accuracy_test {

using namespace lichtenberg;
using namespace lichtenberg::laplace;

namespace {

AccurateSpheres solve(const SphereProblem& problem, double accuracy) {
  return solve_to_accuracy(problem, accuracy, [](double tolerance) { return SphereSolver({.accuracy = tolerance}); });
}

/// Problem of a neutral sphere and a charged one at a distance of 27 radii.
SphereProblem far_apart() {
  SphereProblem problem{.free_space = true, .permittivity = 4.16e-11};
  problem.spheres = {{{0, 0, 0}, 7.45e-4, 0}, {{0.0101, 0.0044, 0.0181}, 7.75e-4, 1}};
  problem.groups = {{.charge = 0}, {.charge = -8.5e-11}};
  return problem;
}

/// Problem of a neutral sphere between plates, closer to a wall.
SphereProblem near_wall() {
  SphereProblem problem{.permittivity = 4.16e-11};
  problem.box.lengths = {0.0084, 0.0084, 0.0084};
  problem.box.sides[0] = problem.box.sides[1] = Boundary::electrode;
  problem.side_potential[1] = 2000;
  problem.spheres = {{{0.00436, 0.000788, 0.004816}, 7.75e-4, 0}};
  problem.groups = {{.charge = 0}};
  return problem;
}

}  // namespace

TEST_CASE("two distant spheres, one neutral: attraction is that of image charges") {
  const SphereProblem problem = far_apart();
  const double q = problem.groups[1].charge, d = norm(problem.spheres[1].centre), r = problem.spheres[0].radius;
  // Kelvin's image and its opposite at the centre attract a point charge. The radius of the charge changes the force by
  // a fraction below (r / d)^3, 3e-5.
  const double image = r * d / std::pow(d * d - r * r, 2) - r / std::pow(d, 3);
  const double force = q * q / (4 * std::numbers::pi * problem.permittivity) * image;
  for (const double accuracy : {1e-1, 1e-2, 1e-3}) {
    CAPTURE(accuracy);
    const AccurateSpheres found = solve(problem, accuracy);
    CHECK(found.estimate <= accuracy);
    for (const int sphere : {0, 1}) {
      const Vec3 towards = problem.spheres[1].centre * ((sphere == 0 ? 1 : -1) * force / d);
      CHECK(norm(found.solution.sphere_force[sphere] - towards) <= (accuracy + 3e-5) * force);
    }
  }
}

TEST_CASE("spheres, solve_to_accuracy: the largest error is below the request") {
  for (const SphereProblem& problem : {far_apart(), near_wall()}) {
    const SphereSolution exact = SphereSolver({.accuracy = 1e-12}).solve(problem);
    for (const double accuracy : {1e-1, 1e-2, 1e-3, 1e-6}) {
      CAPTURE(accuracy);
      const AccurateSpheres found = solve(problem, accuracy);
      const double error = largest_error(problem, found.solution, exact, scales_of(problem, exact));
      CHECK(error <= accuracy);
      CHECK(error <= found.estimate + 0.2 * accuracy);  // The reference is a solution with ten times the accuracy.
    }
  }
}

TEST_CASE("spheres, tolerance: forces that nearly cancel at a gap are accurate") {
  // Charges of one sign repel, and the charges that they induce at the gap attract.
  SphereProblem problem{.free_space = true, .permittivity = 1};
  problem.spheres = {{{0, 0, 0}, 1, 0}, {{0, 0, 1.7606}, 0.7457, 1}};
  problem.groups = {{.charge = 671}, {.charge = 647}};
  const SphereSolution exact = SphereSolver({.accuracy = 1e-9}).solve(problem);
  for (const double tolerance : {1e-2, 1e-3, 1e-4, 1e-5}) {
    CAPTURE(tolerance);
    const SphereSolution found = SphereSolver({.accuracy = tolerance}).solve(problem);
    CHECK(largest_error(problem, found, exact, scales_of(problem, exact)) < tolerance);
  }
}

TEST_CASE("spheres, solve_to_accuracy: request met if the force is zero by symmetry") {
  SphereProblem problem = near_wall();
  problem.spheres[0].centre = problem.box.lengths * 0.5;
  for (const double accuracy : {1e-2, 1e-8}) CHECK(solve(problem, accuracy).estimate <= accuracy);
}

TEST_CASE("spheres, forget: the next solve has the bits of a new solver") {
  for (const double accuracy : {1e-3, 1e-10}) {
    SphereSolver solver({.accuracy = accuracy});
    solver.solve(far_apart());  // The next solve would begin with the smaller tolerance of these forces
    solver.forget();
    const SphereSolution after = solver.solve(near_wall()),
                         fresh = SphereSolver({.accuracy = accuracy}).solve(near_wall());
    CHECK(after.group_potential == fresh.group_potential);
    CHECK(after.sphere_force[0] == fresh.sphere_force[0]);
    CHECK(after.iterations == fresh.iterations);
  }
}

TEST_CASE("sphere in free space: its potential is relative to infinity") {
  SphereProblem problem = far_apart();
  problem.spheres.pop_back(), problem.groups.pop_back();
  problem.groups[0].charge = 1e-10;
  const AccurateSpheres found = solve(problem, 1e-3);
  const double potential = 1e-10 / (4 * std::numbers::pi * problem.permittivity * problem.spheres[0].radius);
  CHECK(found.solution.group_potential[0] == doctest::Approx(potential).epsilon(1e-3));
  CHECK(scales_of(problem, found.solution).potential == found.solution.group_potential[0]);
}

}  // namespace spheres_accuracy_test
