// Tests of conducting spheres in a uniform field in free space: closed forms, energy derivatives, accuracy on request.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "solvers/laplace/spheres/accuracy.hpp"
#include "tests/near.hpp"
#include "tests/sphere_problems.hpp"

namespace spheres_uniform_field_test {

using namespace lichtenberg;
using namespace lichtenberg::laplace;
using namespace lichtenberg::sphere_problems;

namespace {

/// Dipole moment over 4 pi eps E of two neutral spheres of radius 1 at the gap `gap`, whose line of centres is along
/// the field (Davis 1964). In bispherical coordinates with spheres at eta = +-eta_0 the potential is
///   -E z + sqrt(2 (cosh eta - cos theta)) sum_n A_n sinh((n + 1/2) eta) P_n(cos theta).
/// The boundary condition gives A_n = 2 (phi + E c (2 n + 1)) / (exp((2 n + 1) eta_0) - 1) with c = sinh eta_0. The
/// charge of a sphere is 4 pi eps c sum A_n = 0, which gives phi, and the dipole is 8 pi eps c^2 sum (2 n + 1) A_n.
double dipole_of_pair(double gap) {
  const double eta = std::acosh(1 + gap / 2), c = std::sinh(eta);
  double zero = 0, first = 0, second = 0;
  for (int n = 0; (2 * n + 1) * eta < 60; ++n) {
    const double share = 2 / std::expm1((2 * n + 1) * eta);
    zero += share, first += (2 * n + 1) * share, second += (2.0 * n + 1) * (2 * n + 1) * share;
  }
  const double phi = -c * first / zero;
  return 2 * c * c * (phi * first + c * second);
}

/// Two spheres of radius 1 in a field of 1 V/m along z, with 4 pi eps = 1.
SphereProblem pair_along_field(double gap) {
  SphereProblem problem{.free_space = true, .uniform_field = {0, 0, 1}, .permittivity = 1 / (4 * std::numbers::pi)};
  problem.spheres = {{{3, -2, 1}, 1, 0}, {{3, -2, 3 + gap}, 1, 1}};
  problem.groups = {{}, {}};
  return problem;
}

}  // namespace

TEST_CASE("sphere in a uniform field: dipole, potential, energy and force") {
  const Vec3 field{30, -20, 50}, centre{0.1, 0.2, 0.3};
  const double eps = 4e-11, radius = 0.7, charge = 2e-9;
  SphereProblem problem{.free_space = true, .uniform_field = field, .permittivity = eps};
  problem.spheres = {{centre, radius, 0}};
  for (const double q : {0.0, charge}) {
    problem.groups = {{.charge = q}};
    const SphereSolution found = SphereSolver({.accuracy = 1e-10}).solve(problem);
    const double scale = 4 * std::numbers::pi * eps;
    for (int axis = 0; axis < 3; ++axis) {
      CHECK(found.sphere_dipole[0][axis] == near(scale * std::pow(radius, 3) * field[axis], 1e-12));
      CHECK(std::abs(found.sphere_force[0][axis] - q * field[axis]) < 1e-12 * charge * norm(field));
    }
    CHECK(found.group_potential[0] == near(q / (scale * radius) - dot(field, centre), 1e-12));
    // Self-energy, energy of the charge in the field, and half of the dipole's energy.
    CHECK(found.energy ==
          near(q * q / (2 * scale * radius) - q * dot(field, centre) - 0.5 * scale * std::pow(radius, 3) * norm2(field),
               1e-12));
  }
}

TEST_CASE("two neutral spheres in a field: dipole and force of the closed form") {
  // The force is half of the dipole's derivative by the distance. A difference of fourth order at 1e-3 of the gap has
  // an error of about 1e-11. Rounding of the sums over the step is below 1e-10.
  for (const double accuracy : {1e-4, 1e-8})
    for (const double gap : {2.0, 0.3, 0.02}) {
      CAPTURE(gap);
      const SphereSolution found = SphereSolver({.accuracy = accuracy}).solve(pair_along_field(gap));
      const double dipole = found.sphere_dipole[0].z + found.sphere_dipole[1].z, h = 1e-3 * gap;
      CHECK(dipole == near(dipole_of_pair(gap), accuracy));
      CHECK(found.energy == near(-0.5 * dipole_of_pair(gap), accuracy));
      const double slope = (8 * (dipole_of_pair(gap + h) - dipole_of_pair(gap - h)) -
                            (dipole_of_pair(gap + 2 * h) - dipole_of_pair(gap - 2 * h))) /
                           (12 * h);
      const double force = 0.5 * slope;
      CHECK(std::abs(found.sphere_force[1].z - force) < accuracy * std::abs(force));
      CHECK(std::abs(found.sphere_force[0].z + force) < accuracy * std::abs(force));
    }
  // Far apart each dipole is R^3 E, and the force -6 p^2 / d^4, with a relative correction of order (R/d)^3.
  CHECK(dipole_of_pair(98) == near(2, 1e-5));
  CHECK(SphereSolver({.accuracy = 1e-8}).solve(pair_along_field(98)).sphere_force[1].z == near(-6e-8, 1e-5));
}

TEST_CASE("spheres in a uniform field: forces are energy derivatives") {
  SphereProblem problem = mixed_box();
  problem.free_space = true;
  problem.uniform_field = {0.7, -1.1, 0.4};
  problem.side_potential.fill(0);
  // Bounds as in spheres_test.cpp: differences of fourth order, and rounding of the energy over the step.
  for (const int degree : {0, 3})
    for (int sphere = 0; sphere < 3; ++sphere)
      for (int axis = 0; axis < 3; ++axis)
        CHECK(std::abs(slope_error(problem, sphere, axis, 1e-4, 1e-11, degree)) < 1e-7);
}

TEST_CASE("accuracy in a uniform field: estimate holds at any place of origin") {
  for (const Vec3 shift : {Vec3{}, Vec3{0, 0, 1e4}}) {
    SphereProblem problem = pair_along_field(0.1);
    for (Sphere& sphere : problem.spheres) sphere.centre += shift;
    const AccurateSpheres found =
        solve_to_accuracy(problem, 1e-5, [](double tolerance) { return SphereSolver({.accuracy = tolerance}); });
    CHECK(found.estimate <= 1e-5);
    const double dipole = found.solution.sphere_dipole[0].z + found.solution.sphere_dipole[1].z;
    CHECK(dipole == near(dipole_of_pair(0.1), 1e-5));
    CHECK(scales_of(problem, found.solution).potential == near(4.1, 1e-12));  // the field times the extent
  }
}

}  // namespace spheres_uniform_field_test
