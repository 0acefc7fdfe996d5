// Conducting spheres in space: reference solutions, symmetries of the operator, forces as slopes of the energy.
#include <doctest/doctest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "solvers/error.hpp"
#include "solvers/laplace/spheres/close_pairs.hpp"
#include "solvers/laplace/spheres/far_field.hpp"
#include "solvers/laplace/spheres/translation.hpp"
#include "solvers/periodic/dipoles.hpp"
#include "solvers/periodic/ewald.hpp"
#include "tests/dielectric_pair.hpp"
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

/// Force and slope of the energy, which is its negative.
double slope_error(const SphereProblem& problem, int sphere, int axis, double step, double accuracy) {
  SphereSolver solver({.accuracy = accuracy});
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
      CHECK(std::abs(slope_error(mixed_box(), sphere, axis, 1e-4, 1e-11)) < 1e-7);
    }
}

TEST_CASE("two spheres at gaps down to 1e-5 R keep the digits asked for") {
  // C_11, C_12 and the force on the second at potentials 1 and 0, by image charges in 40-digit arithmetic, their force
  // by the derivative of the charges.
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
      // The centres' distance is rounded: 2e-16 of it is 2e-11 of the smallest gap.
      CHECK(std::abs(found.sphere_charge[0] / exact.own - 1) < accuracy);
      CHECK(std::abs(found.sphere_charge[1] / exact.mutual - 1) < accuracy);
      CHECK(std::abs(found.sphere_force[1].z / exact.force - 1) < accuracy);
      CHECK(std::abs(found.sphere_force[0].z / exact.force + 1) < accuracy);
    }
}

TEST_CASE("several gaps on one sphere: potentials and forces to what is asked, in a row and round a corner") {
  for (const double gap : {0.1, 0.03, 0.01})
    for (const bool row : {true, false}) {
      CAPTURE(gap);
      CAPTURE(row);
      const double d = 2 + gap;
      const Vec3 third = row ? Vec3{2 * d, 0, 0} : Vec3{0.5 * d, std::sqrt(0.75) * d, 0};
      SphereProblem problem{.free_space = true, .permittivity = 1};
      problem.spheres = {{{0, 0, 0}, 1, 0}, {{d, 0, 0}, 1, 1}, {third, 1, 2}};
      problem.groups = {{.floating = false, .potential = -1}, {.charge = 15}, {.charge = 0}};
      // Harmonics that need no tails: exp(-alpha 200), alpha = acosh(1 + gap/2), is 2e-9 at .01 R.
      const SphereSolution exact = SphereSolver({.accuracy = 1e-10, .degree = 200}).solve(problem);
      for (const double accuracy : {1e-2, 1e-3, 1e-4, 1e-6}) {
        CAPTURE(accuracy);
        const SphereSolution found = SphereSolver({.accuracy = accuracy}).solve(problem);
        for (int i = 0; i < 3; ++i) {
          CHECK(std::abs(found.group_potential[i] - exact.group_potential[i]) < accuracy);
          // Linear in what each gap leaves out of its sphere, and there are two.
          CHECK(norm(found.sphere_force[i] - exact.sphere_force[i]) < 2 * accuracy * norm(exact.sphere_force[0]));
        }
      }
    }
}

TEST_CASE("several gaps on one sphere: at 1e-4 R potentials and forces still come to what is asked") {
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

TEST_CASE(
    "small gaps in any direction, to a sphere and to an electrode: forces are slopes, the gap has the field of a "
    "plate") {
  SphereProblem problem = mixed_box();
  const double gap = 1e-3;
  problem.spheres[0].centre.z = 0.15 + gap;  // above an electrode
  problem.spheres[2].centre = problem.spheres[1].centre + Vec3{0.6, -0.48, 0.64} * (0.32 + gap);
  problem.groups[2] = {.floating = false, .potential = -1};
  // Fourth order in step / gap = 0.05, with a fifth derivative of some 24 forces: 6e-6 of the force.
  SphereSolver solver({.accuracy = 1e-9});
  const SphereSolution found = solver.solve(problem);
  for (const int sphere : {0, 2})
    for (int axis = 0; axis < 3; ++axis) {
      CAPTURE(sphere);
      CAPTURE(axis);
      CHECK(std::abs(slope_error(problem, sphere, axis, 0.05 * gap, 1e-9)) < 1e-5 * norm(found.sphere_force[sphere]));
    }
  // In the middle of a gap between curved surfaces the field is the difference over the gap, but for gap / R.
  const Vec3 middle = problem.spheres[1].centre + Vec3{0.6, -0.48, 0.64} * (0.2 + 0.5 * gap);
  SphereSolver rough({.accuracy = 1e-3});  // of low degree, so that the field there is the tails'
  rough.solve(problem);
  const PointField between = rough.field(std::vector<Vec3>{middle})[0];
  CHECK(dot(between.field, {0.6, -0.48, 0.64}) == doctest::Approx(1.3 / gap).epsilon(0.02));
  CHECK(between.potential == doctest::Approx(-0.35).epsilon(0.02));
  const PointField below = rough.field(std::vector<Vec3>{{0.1, 0.3, 0.5 * gap}})[0];
  CHECK(below.field.z == doctest::Approx((1 - found.group_potential[0]) / gap).epsilon(0.02));
}

TEST_CASE("spheres of one group may touch, each other and an insulating side") {
  // Two equal spheres in contact have the capacitance 8 pi eps R ln 2 (Maxwell).
  SphereProblem pair{.free_space = true, .permittivity = 1};
  pair.spheres = {{{0, 0, 0}, 1, 0}, {{1.2, 0, 1.6}, 1, 0}};
  pair.groups = {{.floating = false, .potential = 1}};
  const SphereSolution touching = SphereSolver({.accuracy = 1e-9}).solve(pair);
  CHECK(touching.sphere_charge[0] + touching.sphere_charge[1] ==
        doctest::Approx(8 * std::numbers::pi * std::log(2.0)).epsilon(1e-9));
  // They repel each other by 4 pi eps R^2 E^2 (ln 2 - 1/4) / 6 (Kelvin), each with the potential 1.
  CHECK(touching.sphere_force[1].x ==
        doctest::Approx(0.6 * 4 * std::numbers::pi * (std::log(2.0) - 0.25) / 6).epsilon(1e-8));
  // A sphere that lies on an insulating side is half of such a pair.
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

TEST_CASE("cell by cell or pair by pair: the same field") {
  for (const int scene : {0, 1, 2}) {
    CAPTURE(scene);
    SphereProblem problem{.free_space = scene == 0, .permittivity = 1};
    problem.box.lengths = {1, 1.2, scene == 2 ? 0.3 : 0.9};
    if (scene != 1) problem.box.sides[0] = Boundary::electrode;  // without it the sum of dipoles along z has a field
    if (scene == 2) problem.box.sides[2] = problem.box.sides[3] = Boundary::periodic;
    if (scene == 1) problem.box.sides[4] = problem.box.sides[5] = Boundary::electrode;
    for (int i = 0; i < 48; ++i) {
      const double x = 0.1 + 0.16 * (i % 6), y = 0.08 + 0.14 * (i / 6 % 8), z = 0.15 + 0.04 * std::sin(i);
      problem.spheres.push_back({{x, y, z}, 0.05 + 0.01 * std::cos(3 * i), i});
      problem.groups.push_back({.charge = std::sin(2 * i)});
    }
    const SphereSolution pairs = SphereSolver({.accuracy = 1e-6}).solve(problem);
    // One more, too small to matter, and there are cells.
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

TEST_CASE("a moving scene needs fewer iterations, and forgets when told to; threads change no bit") {
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

TEST_CASE("what a gap's tail has of energy is known to some digits at any accuracy, or the matrix is not positive") {
  for (const double gap : {0.05, 0.1, 0.2, 0.3, 0.4}) {
    const int degree = static_cast<int>(-std::log(0.04) / spheres::bispherical_coordinate(1, 1, gap));
    const std::vector<spheres::Site> sites{{{0, 0, 0}, 1, degree}, {{0, 0, 2 + gap}, 1, degree}};
    const std::vector<spheres::NearPair> pair{{0, 1, 0, 1, {0, 0, -2 - gap}}};
    const double rough = spheres::close_pairs(sites, pair, 0.03).at(0).energy;
    CHECK(rough == doctest::Approx(spheres::close_pairs(sites, pair, 1e-8).at(0).energy).epsilon(0.1));
  }
}

TEST_CASE("large groups in a flat dish take few iterations, from nothing and when they merge") {
  constexpr int side = 10;
  SphereProblem problem{.permittivity = 1, .groups = {{.charge = 1}, {.charge = -2}, {.floating = false}}};
  problem.box.lengths = {3.0 * side, 3.0 * side, 6};
  for (int i = 0; i < side * side; ++i)
    problem.spheres.push_back({{1.5 + 3 * (i % side), 1.5 + 3 * (i / side) + 0.2 * (i % 3), 1.1}, 1, i % side / 5});
  problem.spheres.push_back({{15, 15.1, 4}, 1, 2});
  SphereSolver solver({.accuracy = 1e-4});
  CHECK(solver.solve(problem).iterations <= 8);  // 20 without the equations of charges and dipoles
  for (Sphere& sphere : problem.spheres) sphere.group = sphere.group < 2 ? 0 : 1;
  problem.groups = {{.charge = -1}, {.floating = false}};
  CHECK(solver.solve(problem).iterations <= 8);
}

TEST_CASE("spheres far apart in radii, or of very different radii, have their force to the accuracy") {
  // A charge q at distance d from a floating sphere of radius R and charge Q: its image -q R / d at R^2 / d, and the
  // opposite in the middle.
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
        // The small sphere's own dipole is left out of the theory: (small / d)^3 of the force.
        const double exact = force(1, -1, large, 2.2), bound = (accuracy + 2 * std::pow(small, 3)) * std::abs(exact);
        CAPTURE(accuracy);
        CAPTURE(small);
        CAPTURE(large);
        CHECK(std::abs(found.sphere_force[0].x + exact) < bound);
        CHECK(std::abs(found.sphere_force[1].x - exact) < bound);
      }
}

TEST_CASE("when the last charge has gone to ground nothing is left") {
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

TEST_CASE(
    "charges that go on as they went, after a step that was taken back too, are guessed from the last solutions") {
  SphereProblem problem = mixed_box();
  SphereSolver solver({.accuracy = 1e-8});
  const auto iterations = [&](double time) {
    SphereProblem then = problem;
    for (Group& group : then.groups) group.charge *= 1 + time;
    return solver.solve(then).iterations;
  };
  iterations(0);
  const int second = iterations(1);
  // The error of a solution, a tenth of what is asked, is magnified by the mixture: that is left to the iteration.
  CHECK(iterations(1.5) < second / 2);
  CHECK(iterations(0.5) < second / 2);
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

TEST_CASE("several electrodes of one potential only add it to everything") {
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
  // 1/2 sum Q V: what all have more adds up to nothing.
  CHECK(high.energy == doctest::Approx(low.energy).epsilon(1e-9));
  problem.side_potential[0] = 0;
  CHECK_THROWS_AS(SphereSolver().solve(problem), InputError);
}

TEST_CASE("to degree one spheres are the induced dipoles of a gas, polarizability R^3, all images included") {
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
                            [&](const laplace::spheres::MirrorImage&, Vec3 way) {
                              if (norm2(way) > 0) pairs.push_back({t, s, 0, 1, way});
                            });
  parallel::Team& team = parallel::Team::single();
  const laplace::spheres::NearField near(sites, sites, pairs, 1e-13, team);
  const laplace::spheres::FarField far(mirrors, sites, sites, range, 1e-13);
  std::vector<double> a(12), b(12);
  for (int i = 0; i < 3; ++i) a[4 * i] = charge[i] / radius;
  for (int iteration = 0; iteration < 60; ++iteration) {  // each takes off (2 R^3 / d^3), a twentieth
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

namespace {

/// Dense solution of the same equations, by elimination with pivots.
std::vector<double> dense_potentials(const SphereProblem& problem, const std::vector<double>& capacitance) {
  const std::size_t n = problem.groups.size();
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd charge(n);
  for (std::size_t i = 0; i < n; ++i) {
    charge[i] = problem.groups[i].charge;
    for (std::size_t j = 0; j < n; ++j) matrix(i, j) = capacitance[i * n + j];
  }
  for (const Coupling& coupling : problem.couplings) {
    matrix(coupling.a, coupling.a) += coupling.capacitance, matrix(coupling.b, coupling.b) += coupling.capacitance;
    matrix(coupling.a, coupling.b) -= coupling.capacitance, matrix(coupling.b, coupling.a) -= coupling.capacitance;
  }
  for (std::size_t g = 0; g < n; ++g) {
    if (problem.groups[g].floating) continue;
    matrix.row(g).setZero();
    matrix(g, g) = 1;
    charge[g] = problem.groups[g].potential;
  }
  const Eigen::VectorXd potential = matrix.fullPivLu().solve(charge);
  return {potential.begin(), potential.end()};
}

/// Three spheres that float and one that is held at 2 V, with a supply of 5 V that has no sphere. Group 1 is two of
/// them. Coupled: 0 to the supply, 0 to 1, 1 to the held one.
SphereProblem coupled_spheres(bool grounded, double capacitance) {
  SphereProblem problem{.permittivity = 2};
  problem.box.lengths = {1, 0.9, 1.1};
  if (grounded) problem.box.sides[4] = Boundary::electrode;
  problem.spheres = {
      {{0.2, 0.3, 0.4}, 0.15, 0}, {{0.7, 0.3, 0.3}, 0.1, 1}, {{0.3, 0.7, 0.8}, 0.12, 1}, {{0.75, 0.65, 0.7}, 0.14, 2}};
  problem.groups = {
      {.charge = 3}, {.charge = -1}, {.floating = false, .potential = 2}, {.floating = false, .potential = 5}};
  problem.couplings = {{0, 3, 0.4 * capacitance}, {0, 1, capacitance}, {2, 1, 3 * capacitance}, {2, 3, capacitance}};
  return problem;
}

}  // namespace

TEST_CASE("couplings between spheres and with supplies: as from the capacitance matrix, whatever their strength") {
  for (const bool grounded : {true, false}) {
    SphereSolver solver({.accuracy = 1e-10});
    const SphereProblem alone = coupled_spheres(grounded, 0);
    const std::vector<double> matrix = solver.capacitance_matrix(alone);
    int least = 1000, most = 0;
    for (const double strength : {1e-3, 1.0, 1e3, 1e8}) {
      const SphereProblem problem = coupled_spheres(grounded, strength);
      solver.forget();
      const SphereSolution solution = solver.solve(problem);
      least = std::min(least, solution.iterations), most = std::max(most, solution.iterations);
      const std::vector<double> expected = dense_potentials(problem, matrix);
      // Potentials of some volts to the accuracy; the elimination loses 1e-16 times the strength.
      for (int g = 0; g < 4; ++g) CHECK(std::abs(solution.group_potential[g] - expected[g]) < 1e-8);
      std::vector<double> left;
      for (const Group& group : problem.groups) left.push_back(group.charge);
      for (std::size_t k = 0; k < problem.couplings.size(); ++k) {
        const auto& [a, b, capacitance] = problem.couplings[k];
        left[a] -= solution.coupling_charge[k], left[b] += solution.coupling_charge[k];
        const double difference = solution.group_potential[a] - solution.group_potential[b];
        // An error of the potentials by their accuracy is one of what flows; one of rounding, times the strength.
        CHECK(std::abs(solution.coupling_charge[k] - capacitance * difference) < capacitance * 1e-8);
      }
      for (std::size_t i = 0; i < problem.spheres.size(); ++i)
        left[problem.spheres[i].group] -= solution.sphere_charge[i];
      // Rounding of the charges, and of what flows from 5 V to 2 V through all: less than the strength.
      for (int g = 0; g < 2; ++g) CHECK(std::abs(left[g]) < 1e-14 + 1e-15 * strength);
    }
    CHECK(most <= least + 4);
  }
}

TEST_CASE("a coupling without end is a wire, and none is none: both ends of the same potentials and charges") {
  SphereSolver solver({.accuracy = 1e-9});
  SphereProblem problem = coupled_spheres(true, 0);
  problem.couplings = {{0, 1, 0}};
  SphereProblem wired = problem;
  wired.couplings.clear();
  const SphereSolution none = solver.solve(problem), uncoupled = solver.solve(wired);
  CHECK(none.coupling_charge.at(0) == 0);
  CHECK(std::abs(none.group_potential[0] - uncoupled.group_potential[0]) < 1e-8);
  problem.couplings = {{0, 1, 1e9}};
  for (Sphere& sphere : wired.spheres) sphere.group = std::max(0, sphere.group - 1);
  wired.groups = {{.charge = 2}, wired.groups[2]};
  const SphereSolution coupled = solver.solve(problem), merged = solver.solve(wired);
  CHECK(std::abs(coupled.group_potential[0] - merged.group_potential[0]) < 1e-7);
  CHECK(std::abs(coupled.group_potential[1] - merged.group_potential[0]) < 1e-7);
  for (int i = 0; i < 4; ++i) CHECK(std::abs(coupled.sphere_charge[i] - merged.sphere_charge[i]) < 1e-7);
}

TEST_CASE("a coupling to a supply is a wire however large it is") {
  SphereProblem problem{.free_space = true, .permittivity = 4.2e-11};
  problem.groups = {{.charge = 2e-10}, {.charge = 0}, {.floating = false, .potential = 100}};
  problem.spheres = {{{0.003, 0.005, 0.005}, 7.75e-4, 0}, {{0.005, 0.008, 0.005}, 5e-4, 1}};
  for (const double capacitance : {1e5, 1e27, 1e200, 1e300}) {
    problem.couplings = {{1, 2, capacitance}};
    CHECK(SphereSolver({.accuracy = 1e-9}).solve(problem).group_potential[1] == doctest::Approx(100).epsilon(1e-9));
  }
}

TEST_CASE("a neutral sphere in a box of one potential has that potential and no charge anywhere") {
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

TEST_CASE("a moving circuit starts from what its couplings carried") {
  SphereSolver solver({.accuracy = 1e-8});
  SphereProblem problem = coupled_spheres(true, 0.01);  // a hundredth of what charges a sphere
  int warm = 0;
  for (int step = 1; step <= 6; ++step) {
    const SphereSolution solution = solver.solve(problem);
    warm = solution.iterations;
    for (std::size_t k = 0; k < problem.couplings.size(); ++k) {
      problem.groups[problem.couplings[k].a].charge -= solution.coupling_charge[k];
      problem.groups[problem.couplings[k].b].charge += solution.coupling_charge[k];
    }
    problem.spheres[0].centre.x += 1e-4;
    for (Coupling& coupling : problem.couplings) coupling.capacitance *= 1.05;  // longer steps
  }
  solver.forget();
  CHECK(warm < 0.7 * solver.solve(problem).iterations);
}

namespace {

SphereProblem two_dielectrics(double k, double gap) {
  return {.free_space = true,
          .permittivity = 1,
          .spheres = {{{0, 0, 1 + gap / 2}, 1, 0, k}, {{0, 0, -1 - gap / 2}, 1, 1, k}},
          .groups = {{.charge = 1}, {.charge = -1}}};
}

}  // namespace

TEST_CASE("two charged dielectric spheres attract each other as in bispherical coordinates, down to contact") {
  // Far apart, and of no permittivity, those are Coulomb's.
  CHECK(dielectric_pair(1, 4).attraction == doctest::Approx(1 / (4 * std::numbers::pi * 36)).epsilon(1e-12));
  CHECK(dielectric_pair(1, 4).potential == doctest::Approx(1 / (4 * std::numbers::pi) * (1 - 1 / 6.0)).epsilon(1e-12));
  for (const double accuracy : {1e-3, 1e-5})
    for (const double k : {1.5, 5.0, 20.0})
      for (const double gap : {1.0, 1e-1, 1e-2, 1e-4}) {
        if (accuracy < 1e-4 && k > 10 && gap < 1e-2) continue;  // takes more harmonics than there are
        const BisphericalPair exact = dielectric_pair(k, gap);
        const SphereSolution found = SphereSolver({.accuracy = accuracy}).solve(two_dielectrics(k, gap));
        CHECK(std::abs(found.sphere_force[0].z + exact.attraction) < accuracy * exact.attraction);
        CHECK(found.group_potential[0] == doctest::Approx(exact.potential).epsilon(accuracy));
        CHECK(found.sphere_charge[0] == doctest::Approx(1).epsilon(1e-14));
      }
  // At contact itself the force is the limit.
  const SphereSolution touching = SphereSolver({.accuracy = 1e-4}).solve(two_dielectrics(5, 0));
  CHECK(-touching.sphere_force[0].z == doctest::Approx(dielectric_pair(5, 1e-6).attraction).epsilon(1e-3));
}

TEST_CASE("a dielectric sphere in a uniform field has Clausius' and Mossotti's dipole, and its charge is pulled") {
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

TEST_CASE(
    "dielectric spheres among conductors: forces are slopes of the energy, and a huge permittivity is a conductor") {
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

TEST_CASE("what is no problem is refused") {
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
