// Tests of conducting spheres in space: reference solutions, symmetries of the operator, forces as energy derivatives.
#include <doctest/doctest.h>
#include <petscsys.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "solvers/error.hpp"
#include "solvers/laplace/spheres/far_field.hpp"
#include "solvers/parallel/petsc.hpp"
#include "solvers/periodic/dipoles.hpp"
#include "solvers/periodic/ewald.hpp"
#include "tests/sphere_problems.hpp"
#include "tests/sphere_references.hpp"

namespace spheres_test {

using namespace lichtenberg;
using namespace lichtenberg::laplace;
using namespace lichtenberg::sphere_problems;

TEST_CASE("spheres: reference solutions are reproduced to ten digits") {
  for (const sphere_references::SphereReference& reference : sphere_references::read_all_spheres()) {
    CAPTURE(reference.name);
    CHECK(sphere_references::errors_of(reference, 1e-10).worst() < 1e-10);
  }
}

TEST_CASE("sphere forces: energy derivatives at constant charge and potential") {
  // Fourth-order central differences have an error of h^4 times the fifth derivative, about 1/(0.15)^5 of the force:
  // 1e-11. Rounding of the energy, 1e-12, is divided by the step: 1e-8.
  for (int sphere = 0; sphere < 3; ++sphere)
    for (int axis = 0; axis < 3; ++axis) {
      CAPTURE(sphere);
      CAPTURE(axis);
      CHECK(std::abs(slope_error(mixed_box(), sphere, axis, 1e-4, 1e-11)) < 1e-7);
    }
}

/// Largest difference between a force and the energy's derivative over all directions, divided by the largest force.
double worst_slope_error(const SphereProblem& problem, int spheres, int degree) {
  double largest = 0, error = 0;
  for (const Vec3 force : SphereSolver({.accuracy = 1e-11, .degree = degree}).solve(problem).sphere_force)
    largest = std::max(largest, norm(force));
  for (int sphere = 0; sphere < spheres; ++sphere)
    for (int axis = 0; axis < 3; ++axis)
      error = std::max(error, std::abs(slope_error(problem, sphere, axis, 1e-4, 1e-11, degree)));
  return error / largest;
}

TEST_CASE("spheres at fixed degrees 1 to 6: forces are energy derivatives") {
  // The bound is the error of fourth-order differences; the smallest gap of 0.02 is 200 steps wide.
  SphereProblem alone = periodic_mixture();
  alone.free_space = true;
  for (int degree = 1; degree <= 6; ++degree) {
    CAPTURE(degree);
    CHECK(worst_slope_error(mixed_box(), 3, degree) < 1e-7);
    CHECK(worst_slope_error(periodic_mixture(), 3, degree) < 1e-7);
    CHECK(worst_slope_error(alone, 3, degree) < 1e-7);
  }
}

TEST_CASE("64 spheres (cell method) at degree 2: force is energy derivative" * doctest::test_suite("long")) {
  SphereProblem box{.permittivity = 1};
  box.box.lengths = {4, 4, 4};
  box.box.sides.fill(Boundary::periodic);
  for (int i = 0; i < 64; ++i) {
    const Vec3 at{0.5 + i % 4 + 0.2 * std::sin(i), 0.5 + i / 4 % 4 + 0.2 * std::sin(2 * i),
                  0.5 + i / 16 + 0.2 * std::sin(3 * i)};
    box.spheres.push_back({at, 0.29, i, 6.0});
    box.groups.push_back({.charge = i % 2 == 0 ? 1.0 : -1.0});
  }
  SphereProblem alone = box;
  alone.free_space = true;
  for (const SphereProblem& problem : {box, alone}) {
    constexpr int degree = 2;
    const double force = norm(SphereSolver({.accuracy = 1e-11, .degree = degree}).solve(problem).sphere_force[0]);
    // Rounding of the energy of 64 spheres, divided by the step.
    CHECK(std::abs(slope_error(problem, 0, 0, 1e-4, 1e-11, degree)) < 1e-6 * force);
  }
}

TEST_CASE("spheres: cell method and direct pair sum give equal potentials, forces") {
  for (const int scene : {0, 1, 2}) {
    CAPTURE(scene);
    SphereProblem problem{.free_space = scene == 0, .permittivity = 1};
    problem.box.lengths = {1, 1.2, scene == 2 ? 0.3 : 0.9};
    // Without this electrode the sum of dipoles along z has a field.
    if (scene != 1) problem.box.sides[0] = Boundary::electrode;
    if (scene == 2) problem.box.sides[2] = problem.box.sides[3] = Boundary::periodic;
    if (scene == 1) problem.box.sides[4] = problem.box.sides[5] = Boundary::electrode;
    for (int i = 0; i < 48; ++i) {
      const double x = 0.1 + 0.16 * (i % 6), y = 0.08 + 0.14 * (i / 6 % 8), z = 0.15 + 0.04 * std::sin(i);
      problem.spheres.push_back({{x, y, z}, 0.05 + 0.01 * std::cos(3 * i), i});
      problem.groups.push_back({.charge = std::sin(2 * i)});
    }
    const SphereSolution pairs = SphereSolver({.accuracy = 1e-6}).solve(problem);
    // A negligible additional sphere switches to the cell method.
    problem.spheres.push_back({{0.02, 0.02, 0.02}, 1e-5, 48});
    problem.groups.push_back({});
    const SphereSolution cells = SphereSolver({.accuracy = 1e-6}).solve(problem);
    double largest = 0, error = 0, force = 0, force_error = 0;
    for (int i = 0; i < 48; ++i) {
      largest = std::max(largest, std::abs(pairs.group_potential[i]));
      error = std::max(error, std::abs(pairs.group_potential[i] - cells.group_potential[i]));
      force = std::max(force, norm(pairs.sphere_force[i]));
      force_error = std::max(force_error, norm(pairs.sphere_force[i] - cells.sphere_force[i]));
    }
    CHECK(error < 2e-6 * largest);
    CHECK(force_error < 2e-6 * force);
  }
}

TEST_CASE("periodic spheres at accuracy 1e-11: one and two periods agree to 1e-11") {
  SphereProblem one{.permittivity = 1};
  one.box.lengths = {3, 3, 3};
  one.box.sides.fill(Boundary::periodic);
  for (int i = 0; i < 27; ++i) {
    one.spheres.push_back(
        {{0.5 + i % 3 + 0.1 * std::sin(i), 0.5 + i / 3 % 3, 0.5 + i / 9 + 0.1 * std::cos(2 * i)}, 0.2, i});
    one.groups.push_back({.charge = i == 26 ? 0.0 : i % 2 == 0 ? 1.0 : -1.0});
  }
  // Images are summed directly for 27 spheres and by cells for 54, with other Ewald splittings.
  SphereProblem two = one;
  two.box.lengths.x = 6;
  for (int i = 0; i < 27; ++i) {
    Sphere next = one.spheres[i];
    next.centre.x += 3, next.group += 27;
    two.spheres.push_back(next);
    two.groups.push_back(one.groups[i]);
  }
  const auto largest_difference = [&](double accuracy) {
    const SphereSolution a = SphereSolver({.accuracy = accuracy}).solve(one),
                         b = SphereSolver({.accuracy = accuracy}).solve(two);
    double force = 0, potential = 0, error = 0, force_error = 0;
    for (int i = 0; i < 27; ++i) {
      potential = std::max(potential, std::abs(a.group_potential[i]));
      force = std::max(force, norm(a.sphere_force[i]));
      error = std::max(error, std::abs(a.group_potential[i] - b.group_potential[i]));
      force_error = std::max(force_error, norm(a.sphere_force[i] - b.sphere_force[i]));
    }
    return std::max(error / potential, force_error / force);
  };
  CHECK(largest_difference(1e-11) < 1e-11);
  CHECK(largest_difference(1e-8) > 1e-11);  // The difference is no rounding.
}

TEST_CASE("SphereSolver: history saves iterations, threads give identical bits") {
  SphereProblem problem = mixed_box();
  SphereSolver solver({.accuracy = 1e-8});
  const SphereSolution first = solver.solve(problem);
  problem.spheres[0].centre.x += 1e-6;
  CHECK(solver.solve(problem).iterations < first.iterations);
  solver.forget();
  parallel::Team team(3);
  const SphereSolution alone = solver.solve(problem), together = SphereSolver({.accuracy = 1e-8}, team).solve(problem);
  CHECK(alone.group_potential == together.group_potential);
  CHECK(alone.sphere_force[1] == together.sphere_force[1]);
}

TEST_CASE("100 spheres in two groups in a flat box: at most 8 iterations") {
  constexpr int side = 10;
  SphereProblem problem{.permittivity = 1, .groups = {{.charge = 1}, {.charge = -2}, {.floating = false}}};
  problem.box.lengths = {3.0 * side, 3.0 * side, 6};
  for (int i = 0; i < side * side; ++i)
    problem.spheres.push_back({{1.5 + 3 * (i % side), 1.5 + 3 * (i / side) + 0.2 * (i % 3), 1.1}, 1, i % side / 5});
  problem.spheres.push_back({{15, 15.1, 4}, 1, 2});
  SphereSolver solver({.accuracy = 1e-4});
  CHECK(solver.solve(problem).iterations <= 8);  // 20 without the equations of charges and dipoles.
  for (Sphere& sphere : problem.spheres) sphere.group = sphere.group < 2 ? 0 : 1;
  problem.groups = {{.charge = -1}, {.floating = false}};
  CHECK(solver.solve(problem).iterations <= 8);
}

// The iteration also computes the product with the result, but in this variant not from the directions of its steps.
TEST_CASE("spheres: CG with a single reduction gives the forces of plain CG") {
  constexpr int side = 4;
  constexpr double accuracy = 1e-3;
  SphereProblem problem{.permittivity = 1};
  problem.box.lengths = {2.1 * side, 2.1 * side, 2.1 * side};
  for (int i = 0; i < side * side * side; ++i) {
    problem.groups.push_back({.charge = std::sin(1.0 + 7 * i)});
    const Vec3 cell{static_cast<double>(i % side), static_cast<double>(i / side % side),
                    static_cast<double>(i / side / side)};
    problem.spheres.push_back({2.05 * cell + Vec3{1.05, 1.05, 1.05}, 1, i});
  }
  problem.groups.front() = {.floating = false};
  const SphereSolution plain = SphereSolver({.accuracy = accuracy}).solve(problem);
  parallel::start_petsc();
  parallel::check_petsc(PetscOptionsSetValue(nullptr, "-spheres_ksp_cg_single_reduction", "true"));
  const SphereSolution single = SphereSolver({.accuracy = accuracy}).solve(problem);
  parallel::check_petsc(PetscOptionsClearValue(nullptr, "-spheres_ksp_cg_single_reduction"));
  double largest = 0, difference = 0;
  for (std::size_t k = 0; k < problem.spheres.size(); ++k) {
    largest = std::max(largest, norm(plain.sphere_force[k]));
    difference = std::max(difference, norm(plain.sphere_force[k] - single.sphere_force[k]));
  }
  CHECK(difference < 2 * accuracy * largest);  // Each is within the accuracy.
}

TEST_CASE("sphere force: accurate at a distance and for radius ratios of 1e-5") {
  // A charge q at distance d from a floating sphere of radius R and charge Q has the image -q R / d at R^2 / d and the
  // opposite image at the centre.
  const auto force = [](double q, double other, double radius, double d) {
    const double image = q * radius / d;
    return q * ((other + image) / (d * d) - image / std::pow(d - radius * radius / d, 2)) / (4 * std::numbers::pi);
  };
  for (const double accuracy : {1e-2, 1e-3, 1e-6})
    for (const double small : {1e-2, 1e-3, 1e-5})
      for (const double large : {1.0, small}) {
        const SphereProblem problem{.free_space = true,
                                    .permittivity = 1,
                                    .spheres = {{{0, 0, 0}, small, 0}, {{2.2, 0, 0}, large, 1}},
                                    .groups = {{.floating = true, .charge = 1}, {.floating = true, .charge = -1}}};
        const SphereSolution found = SphereSolver({.accuracy = accuracy}).solve(problem);
        // The theory neglects the small sphere's dipole: (small / d)^3 of the force.
        const double exact = force(1, -1, large, 2.2), bound = (accuracy + 2 * std::pow(small, 3)) * std::abs(exact);
        CAPTURE(accuracy);
        CAPTURE(small);
        CAPTURE(large);
        CHECK(std::abs(found.sphere_force[0].x + exact) < bound);
        CHECK(std::abs(found.sphere_force[1].x - exact) < bound);
      }
}

TEST_CASE("insulated box, one sphere at -100 V: all potentials equal, no charge") {
  SphereProblem problem{.permittivity = 4e-11};
  problem.box.lengths = {0.06, 0.02, 0.02};
  problem.groups = {{.floating = false, .potential = -100}, {.charge = 0}};
  problem.spheres = {{{0.0119, 0.0174, 0.0151}, 1e-3, 0}, {{0.001000001, 0.0039, 0.0122}, 1e-3, 1}};
  for (const double accuracy : {1e-2, 1e-6}) {
    const SphereSolution solution = SphereSolver({.accuracy = accuracy}).solve(problem);
    CHECK(solution.group_potential[1] == doctest::Approx(-100).epsilon(1e-12));
    CHECK(std::abs(solution.sphere_charge[0]) < 1e-12 * 4e-11 * 0.1);  // Relative to eps R V.
  }
}

void check_columns(SphereProblem problem, double accuracy) {
  const std::vector<double> matrix = SphereSolver({.accuracy = accuracy}).capacitance_matrix(problem);
  const std::size_t groups = problem.groups.size();
  const double largest = std::abs(std::ranges::max(matrix, {}, [](double c) { return std::abs(c); }));
  for (const std::size_t column : {std::size_t{0}, groups / 2, groups - 1}) {
    for (std::size_t g = 0; g < groups; ++g)
      problem.groups[g] = {.floating = false, .potential = g == column ? 1. : 0.};
    std::vector<double> charge(groups);
    const SphereSolution solution = SphereSolver({.accuracy = accuracy}).solve(problem);
    for (std::size_t i = 0; i < problem.spheres.size(); ++i)
      charge[problem.spheres[i].group] += solution.sphere_charge[i];
    for (std::size_t g = 0; g < groups; ++g) {
      CHECK(std::abs(matrix[g * groups + column] - charge[g]) < accuracy * largest);
      CHECK(std::abs(matrix[g * groups + column] - matrix[column * groups + g]) < accuracy * largest);
    }
  }
}

TEST_CASE("sphere capacitance matrix: columns are charges at unit potentials") {
  SphereProblem problem{.permittivity = 2};
  problem.box.lengths = {1, 1.2, 0.9};
  for (int i = 0; i < 11; ++i) {  // More than eight groups; the last one has two spheres.
    const double x = 0.15 + 0.3 * (i % 3), y = 0.15 + 0.3 * (i / 3), z = 0.3 + 0.1 * std::sin(i);
    problem.spheres.push_back({{x, y, z}, 0.1 + 0.02 * std::cos(3 * i), std::min(i, 9)});
  }
  problem.groups.resize(10);
  check_columns(problem, 1e-8);  // An insulated box.
  problem.box.sides[2] = Boundary::electrode;
  check_columns(problem, 1e-8);
  problem.free_space = true;
  check_columns(problem, 1e-8);
}

TEST_CASE("capacitance matrix of 64 spheres: columns are charges" * doctest::test_suite("long")) {
  SphereProblem many{.permittivity = 2};
  many.box.lengths = {4, 4, 4};
  many.box.sides[2] = Boundary::electrode;
  for (int i = 0; i < 64; ++i)
    many.spheres.push_back({{0.5 + i % 4 + 0.1 * std::sin(i), 0.5 + i / 4 % 4, 0.5 + i / 16}, 0.3, i % 5});
  many.groups.resize(5);
  check_columns(many, 1e-5);
}

TEST_CASE("SphereSolver: reused geometry does not change the solution") {
  SphereProblem problem = mixed_box();
  SphereSolver solver({.accuracy = 1e-10});
  solver.solve(problem);
  problem.groups[0].charge = -2;
  problem.side_potential[4] = 3;
  const SphereSolution again = solver.solve(problem), anew = SphereSolver({.accuracy = 1e-10}).solve(problem);
  for (int i = 0; i < 3; ++i) {
    CHECK(again.group_potential[i] == doctest::Approx(anew.group_potential[i]).epsilon(1e-9));
    CHECK(norm(again.sphere_force[i] - anew.sphere_force[i]) < 1e-9 * norm(anew.sphere_force[0]));
  }
  problem.spheres[2].radius = 0.14;  // The centres are the same.
  const SphereSolution larger = solver.solve(problem), expected = SphereSolver({.accuracy = 1e-10}).solve(problem);
  CHECK(larger.group_potential[2] == doctest::Approx(expected.group_potential[2]).epsilon(1e-9));
}

TEST_CASE("SphereSolver after all charge went to ground: no force, no iteration") {
  SphereProblem problem = mixed_box();
  problem.side_potential.fill(0);
  problem.groups[1].potential = 0;
  SphereSolver solver;
  solver.solve(problem);
  for (Group& group : problem.groups) group = {.charge = 1e-25};
  CHECK(solver.solve(problem).group_potential[0] > 0);
  solver.forget();
  problem.groups[0].charge = 1;
  solver.solve(problem);
  for (Group& group : problem.groups) group = {.floating = false, .potential = 0};
  const SphereSolution left = solver.solve(problem);
  CHECK(left.iterations == 0);
  for (const Vec3 force : left.sphere_force) CHECK(norm(force) == 0);
}

TEST_CASE("sphere history: extrapolates linear charge growth, also backwards") {
  SphereProblem problem = mixed_box();
  SphereSolver solver({.accuracy = 1e-8});
  const auto iterations = [&](double time) {
    SphereProblem then = problem;
    for (Group& group : then.groups) group.charge *= 1 + time;
    return solver.solve(then).iterations;
  };
  iterations(0);
  const int second = iterations(1);
  // The mixture amplifies the solutions' error, 10 % of the requested one; the iteration removes it.
  CHECK(iterations(1.5) < second / 2);
  CHECK(iterations(0.5) < second / 2);
}

TEST_CASE("spheres in free space: forces sum to zero") {
  SphereProblem problem{.free_space = true, .permittivity = 1};
  problem.spheres = {{{0, 0, 0}, 1, 0}, {{2.3, 0.2, 0.1}, 0.8, 1}, {{0.4, 2.1, -0.7}, 0.6, 2}};
  problem.groups = {{.charge = 1}, {.floating = false, .potential = -0.2}, {.charge = 3}};
  Vec3 sum;
  for (const Vec3 force : SphereSolver({.accuracy = 1e-11}).solve(problem).sphere_force) sum += force;
  CHECK(norm(sum) < 1e-10);
}

TEST_CASE("spheres and electrodes: their charges sum to zero") {
  const SphereProblem problem = mixed_box();
  const SphereSolution solution = SphereSolver({.accuracy = 1e-11}).solve(problem);
  double sum = 0;
  for (const double q : solution.sphere_charge) sum += q;
  for (const double q : solution.side_charge) sum += q;
  CHECK(std::abs(sum) < 1e-11);
}

TEST_CASE("electrodes at one potential: it is added to all sphere potentials") {
  SphereProblem problem = mixed_box();
  problem.box.sides = {Boundary::electrode, Boundary::wall,      Boundary::electrode,
                       Boundary::electrode, Boundary::electrode, Boundary::wall};
  problem.spheres[0].centre.x = 0.3;
  problem.spheres[2].centre.x = 0.8;
  problem.side_potential.fill(0);
  problem.groups[1] = {.charge = 2};
  const SphereSolution low = SphereSolver({.accuracy = 1e-9}).solve(problem);
  problem.side_potential.fill(7);
  const SphereSolution high = SphereSolver({.accuracy = 1e-9}).solve(problem);
  for (int g = 0; g < 3; ++g)
    CHECK(high.group_potential[g] - low.group_potential[g] == doctest::Approx(7).epsilon(1e-9));
  CHECK(high.electrode_charge == doctest::Approx(-2.3).epsilon(1e-12));
  // 1/2 sum Q V: the common potential multiplies a total charge of zero.
  CHECK(high.energy == doctest::Approx(low.energy).epsilon(1e-9));
  problem.side_potential[0] = 0;
  CHECK_THROWS_AS(SphereSolver().solve(problem), InputError);
}

TEST_CASE("spheres at degree one: equal induced dipoles of polarizability R^3") {
  SphereProblem problem{.permittivity = 1 / (4 * std::numbers::pi)};
  problem.box.lengths = {1, 1.2, 0.9};
  problem.box.sides.fill(Boundary::periodic);
  const std::vector<double> position = {0.1, 0.3, 0.4, 0.5, 0.6, 0.7, 0.9, 0.2, 0.75}, charge = {1, 0.5, -1.5};
  const double radius = 0.1;
  std::vector<laplace::spheres::Site> sites;
  std::vector<laplace::spheres::NearPair> pairs;
  for (int i = 0; i < 3; ++i) sites.push_back({{position[3 * i], position[3 * i + 1], position[3 * i + 2]}, radius, 1});
  const laplace::spheres::Mirrors mirrors(problem);
  const double range = 1.1;
  for (int t = 0; t < 3; ++t)
    for (int s = 0; s < 3; ++s)
      mirrors.for_each_near(sites[t].centre, sites[s].centre, range,
                            [&](const laplace::spheres::MirrorImage&, Vec3 shift) {
                              if (norm2(shift) > 0) pairs.push_back({t, s, 0, 1, shift});
                            });
  parallel::Team& team = parallel::Team::single();
  const laplace::spheres::NearField near(sites, sites, pairs, 1e-13, team);
  const laplace::spheres::FarField far(mirrors, sites, sites,
                                       laplace::spheres::images_beyond(range, radius, radius, 1e-13));
  std::vector<double> a(12), b(12);
  for (int i = 0; i < 3; ++i) a[4 * i] = charge[i] / radius;
  for (int iteration = 0; iteration < 60; ++iteration) {  // Each iteration reduces the error to 2 R^3 / d^3 = 5 %.
    std::fill(b.begin(), b.end(), 0.0);
    near.add(a.data(), b.data(), team);
    far.add(a.data(), b.data(), team);
    for (int i = 0; i < 3; ++i)
      for (int k = 1; k < 4; ++k) a[4 * i + k] = -b[4 * i + k];
  }
  periodic::Ewald ewald(1e-13);
  std::vector<double> dipole;
  periodic::Response response;
  periodic::InducedDipoles(ewald, periodic::DipoleSum::ewald, radius * radius * radius, 1e-13)
      .evaluate({problem.box.lengths, position, charge}, {}, team, dipole, response);
  using laplace::spheres::at;
  for (int i = 0; i < 3; ++i) {
    CHECK(radius * radius * a[4 * i + at(1, 1)] == doctest::Approx(dipole[3 * i]).epsilon(1e-10));
    CHECK(radius * radius * a[4 * i + at(1, -1)] == doctest::Approx(dipole[3 * i + 1]).epsilon(1e-10));
    CHECK(radius * radius * a[4 * i + at(1, 0)] == doctest::Approx(dipole[3 * i + 2]).epsilon(1e-10));
  }
}

TEST_CASE("spheres in an insulated box: charges cancel, mean sphere potential is 0") {
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

TEST_CASE("neutral sphere in a box at 50 V: has 50 V and no side charge") {
  SphereProblem problem{.permittivity = 1};
  problem.box.lengths = {0.01, 0.01, 0.01};
  problem.box.sides[4] = Boundary::electrode;
  problem.side_potential.fill(50);
  problem.groups = {{.charge = 0}};
  problem.spheres = {{{0.004, 0.005, 0.006}, 1e-3, 0}};
  const SphereSolution solution = SphereSolver({.accuracy = 1e-6}).solve(problem);
  CHECK(std::abs(solution.group_potential[0] - 50) < 1e-12);
  CHECK(std::abs(solution.side_charge[4]) < 1e-12);
}

TEST_CASE("SphereProblem: numbers that are not finite are refused") {
  const auto check_refused = [](const std::string& message, const auto& change) {
    for (const double bad : {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
      SphereProblem problem = mixed_box();
      change(problem, bad);
      CHECK_THROWS_WITH_AS(problem.check(), message.c_str(), InputError);
    }
  };
  check_refused("sphere 1: its radius must be positive and finite", [](auto& p, double x) { p.spheres[1].radius = x; });
  check_refused("sphere 1: its centre must be finite", [](auto& p, double x) { p.spheres[1].centre.y = x; });
  check_refused("the permittivity must be positive and finite", [](auto& p, double x) { p.permittivity = x; });
  check_refused("the lengths of the box must be positive and finite", [](auto& p, double x) { p.box.lengths.y = x; });
  check_refused("side back: its potential must be finite", [](auto& p, double x) { p.side_potential[5] = x; });
  check_refused("group 0: its charge or potential must be finite", [](auto& p, double x) { p.groups[0].charge = x; });
  check_refused("group 1: its charge or potential must be finite",
                [](auto& p, double x) { p.groups[1].potential = x; });
  check_refused("the uniform field must be finite", [](auto& p, double x) {
    p.free_space = true;
    p.uniform_field.z = x;
  });
}

TEST_CASE("SphereProblem: invalid problems are refused") {
  SphereProblem problem = mixed_box();
  problem.spheres[0].centre.z = 0.14;
  CHECK_THROWS_WITH_AS(problem.check(),
                       "sphere 0 is on or through the side front: its centre is 0.14 m from it, its radius 0.15 m",
                       InputError);
  problem = mixed_box();
  problem.spheres[0].centre = {0.5, 0.6, 0.4};
  CHECK_THROWS_WITH_AS(problem.check(), "spheres 0 and 1 touch, but belong to different groups", InputError);
  problem = {.free_space = true, .permittivity = 1};
  problem.spheres = {{{0, 0, 0}, 1, 0}, {{0, 0, 1.975}, 1, 0}};
  problem.groups = {{.charge = 1}};
  CHECK_THROWS_WITH_AS(problem.check(),
                       "spheres 0 and 1 overlap by 2.5 % of the smaller radius: at most 1 % is allowed", InputError);
  problem.spheres = {{{0, 0, 0}, 1, 0}, {{0, 0, 2 + 1e-10}, 1, 1}};
  problem.groups = {{.floating = false, .potential = 1}, {.floating = false}};
  CHECK_THROWS_WITH_AS(SphereSolver().solve(problem),
                       doctest::Contains("spheres 0 and 1 are 1e-10 m apart at different potentials"), Failure);
  problem = mixed_box();
  problem.box.sides[1] = Boundary::wall;
  CHECK_THROWS_AS(problem.check(), InputError);
  CHECK_THROWS_AS(SphereSolver({.degree = 201}), InputError);
  problem = mixed_box();
  problem.groups.push_back({.charge = 1});
  CHECK_THROWS_WITH_AS(problem.check(), "group 3 has no sphere, and is coupled to none that has", InputError);
  problem.couplings = {{0, 4, 1}};
  CHECK_THROWS_WITH_AS(problem.check(), "coupling 0 must join two different groups of 0 to 3, not 0 and 4", InputError);
  problem.couplings = {{0, 3, -1}};
  CHECK_THROWS_WITH_AS(problem.check(), "coupling 0 must have a finite capacitance that is not negative", InputError);
  problem.couplings = {{0, 3, 1}};
  problem.check();
  problem.spheres[1].relative_permittivity = 2;
  CHECK_THROWS_WITH_AS(problem.check(), "group 1: a dielectric sphere must be alone in a floating group", InputError);
  problem.spheres[0].relative_permittivity = 1;
  CHECK_THROWS_WITH_AS(problem.check(), "sphere 0: its permittivity must be more than that outside", InputError);
}

}  // namespace spheres_test
