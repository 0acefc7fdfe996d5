#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "solvers/error.hpp"
#include "solvers/laplace/relaxation/solver.hpp"

namespace relaxation_test {

using namespace lichtenberg;
using namespace lichtenberg::laplace;
using doctest::Approx;
using std::numbers::pi;

namespace {

// Lengths are in lattice spacings: a box of S spacings has the length S, and eps = 1.

void set_all_sides(LaplaceProblem& problem, Side side) { problem.sides.fill(side); }

Side electrode(double potential) { return {.kind = Side::Kind::electrode, .potential = potential, .profile = {}}; }

/// Bipolar potential of line charges +1 and -1 (2 pi eps = 2 pi).
double bipolar(Vec2 plus, Vec2 minus, Vec2 p) { return std::log(norm(p - minus) / norm(p - plus)) / (2 * pi); }

/// Problem of two equal disks with `ratio` = d / 2R. The sides of the box and the second disk have the exact potential;
/// the first floats with charge 1 (D 6.5.4). Line charges at +-a, a = sqrt(d^2/4 - R^2), make both circles
/// equipotential at +- acosh(d / 2R) / 2 pi.
LaplaceProblem pair_in_plane(double radius, double ratio, int sites, Vec2 shift) {
  const double half = radius * ratio, a = std::sqrt(half * half - radius * radius);
  const Vec2 centre = Vec2{0.5 * sites, 0.5 * sites} + shift;
  const Vec2 plus = centre - Vec2{a, 0}, minus = centre + Vec2{a, 0};
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {1.0 * sites, 1.0 * sites};
  set_all_sides(problem, {.kind = Side::Kind::electrode, .potential = 0, .profile = [=](Vec2 p) {
                            return bipolar(plus, minus, p);
                          }});
  problem.bodies = {{Disk{centre - Vec2{half, 0}, radius}, 0}, {Disk{centre + Vec2{half, 0}, radius}, 1}};
  problem.groups = {{.charge = 1}, {.floating = false, .potential = -std::acosh(ratio) / (2 * pi)}};
  return problem;
}

double pair_capacitance(double ratio) { return pi / std::acosh(ratio); }  // D 6.37

double pair_force(double radius, double ratio) {
  return 1 / (4 * pi * radius * std::sqrt(ratio * ratio - 1));  // Q^2 / (2 pi eps 2a)
}

struct PairErrors {
  double capacitance = 0, force = 0;  ///< Relative errors, averaged over positions.
};
PairErrors pair_errors(double radius, double ratio, Stress stress = Stress::maxwell) {
  const int sites = static_cast<int>(16 * radius), positions = 6;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> within_a_cell(0, 1);
  PairErrors mean;
  for (int k = 0; k < positions; ++k) {
    const Vec2 shift = {within_a_cell(random), within_a_cell(random)};
    RelaxationSolver solver({.sites = sites, .stress = stress});
    const LaplaceProblem problem = pair_in_plane(radius, ratio, sites, shift);
    const LaplaceSolution solution = solver.solve(problem);
    const double capacitance = 1 / (solution.group_potential[0] - problem.groups[1].potential);
    mean.capacitance += std::abs(capacitance / pair_capacitance(ratio) - 1) / positions;
    mean.force += std::abs(solution.body_force[0].x / pair_force(radius, ratio) - 1) / positions;
  }
  return mean;
}

LaplaceProblem neutral_quartet() {
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {64, 64};
  problem.bodies = {
      {Disk{{14, 17}, 6.4}, 0}, {Disk{{45, 13}, 4.5}, 1}, {Disk{{40, 42}, 7.7}, 2}, {Disk{{13, 48}, 3.2}, 2}};
  problem.groups = {{.charge = 1}, {.charge = -0.25}, {.charge = -0.75}};
  return problem;
}

/// Problem of two disks with d / 2R = 4 in a box with insulating sides: the first floats with charge 1, the second is
/// at 0.
LaplaceProblem floating_near_grounded() {
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {128, 128};
  problem.bodies = {{Disk{{32.3, 64.4}, 8}, 0}, {Disk{{96.3, 64.4}, 8}, 1}};
  problem.groups = {{.charge = 1}, {.floating = false, .potential = 0}};
  return problem;
}

}  // namespace

TEST_CASE("over-relaxation: known factor and sweeps per decade for 512 sites") {
  CHECK(over_relaxation(512) == Approx(1.98780).epsilon(5e-6));
  CHECK(sweeps_per_decade(512) == Approx(92.8).epsilon(5e-4));
}

TEST_CASE("relaxation solver: reproduces the potential x^2 - y^2 exactly") {
  // x^2 - y^2 solves the five-point equation, and its mean over the corners of a cell is its value at the centre.
  const auto exact = [](Vec2 p) { return p.x * p.x - p.y * p.y; };
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {24, 16};
  set_all_sides(problem, {.kind = Side::Kind::electrode, .potential = 0, .profile = exact});
  RelaxationSolver solver({.sites = 24, .tolerance = 1e-11});
  const LaplaceSolution solution = solver.solve(problem);
  const Field field = solver.field();
  REQUIRE(field.nx == 24);
  REQUIRE(field.ny == 16);
  for (int j = 0; j < 16; ++j)
    for (int i = 0; i < 24; ++i) CHECK(field.value[j * 24 + i] == Approx(exact({i + 0.5, j + 0.5})).epsilon(1e-8));
  // There is no charge inside: flux through one side leaves through the others. On the left, -integral of dV/dx is 0 at
  // x = 0, except for the one-sided difference V(0) - V(1) = -1 on 15 sites and two halves.
  CHECK(solution.side_charge[left] == Approx(-16).epsilon(1e-8));
}

TEST_CASE("relaxation solver, plate capacitor: exact for a surface on sites") {
  LaplaceProblem problem;
  problem.size = {32, 24};
  problem.permittivity = 3;
  problem.sides[bottom] = electrode(0);
  problem.bodies = {{Bar{{0, 18}, {32, 18}, 4}, 0}};  // The lower surface is at y = 16.
  problem.groups = {{.floating = false, .potential = 8}};
  RelaxationSolver solver({.sites = 32, .tolerance = 1e-10});
  const LaplaceSolution solution = solver.solve(problem);
  const double charge = 3 * 8 * 32 / 16.0;  // eps V width / gap.
  CHECK(solution.side_charge[bottom] == Approx(-charge).epsilon(1e-8));
  CHECK(solution.body_charge[0] == Approx(charge).epsilon(5e-3));  // Ends of the contour: 500 points on 73 spacings.
  CHECK(solution.energy == Approx(0.5 * charge * 8).epsilon(1e-8));
  CHECK(solution.body_force[0].y == Approx(-0.5 * charge * 8 / 16).epsilon(5e-3));  // eps/2 E^2 width.
  CHECK(solver.field().value[4 * 32 + 7] == Approx(8 * 4.5 / 16).epsilon(1e-8));
}

TEST_CASE("relaxation solver, two disks: capacitance and force of first order") {
  // The staircase shifts the surface by a fraction of a spacing that does not depend on R: the error is proportional to
  // 1 / R. Its mean over random positions halves with each doubling, within the scatter of six positions.
  const PairErrors r4 = pair_errors(4, 2), r8 = pair_errors(8, 2), r16 = pair_errors(16, 2);
  for (const double ratio : {r4.capacitance / r8.capacitance, r8.capacitance / r16.capacitance,  //
                             r4.force / r8.force, r8.force / r16.force}) {
    CHECK(ratio > 1.5);
    CHECK(ratio < 2.8);
  }
  // A surface half a spacing too far inside at R = 16 changes acosh(d / 2R) = 1.317 by (1/32) 2 / sqrt(3) = 0.036: 2.7
  // %.
  CHECK(r16.capacitance < 0.027);
  CHECK(r16.force < 0.027);
}

TEST_CASE("relaxation solver: force of the printed formula is 7.7 % too small") {
  // The integral of (dV/dn)^2 n / 2 over the circle of radius R + sqrt(2) in the exact field of d / 2R = 2 is 7.7 %
  // below the force at R = 16. The scheme's staircase adds the error of the full stress.
  const double radius = 16, ratio = 2, half = radius * ratio, a = std::sqrt(half * half - radius * radius);
  const int n = 500;
  double printed = 0;
  for (int k = 0; k < n; ++k) {
    const Vec2 normal = {std::cos(2 * pi * k / n), std::sin(2 * pi * k / n)};
    const double r = radius + std::numbers::sqrt2;
    const Vec2 p = Vec2{-half, 0} + r * normal, from_plus = p - Vec2{-a, 0}, from_minus = p - Vec2{a, 0};
    const double field = dot(from_plus / norm2(from_plus) - from_minus / norm2(from_minus), normal) / (2 * pi);
    printed += 0.5 * field * field * normal.x * 2 * pi * r / n;
  }
  const double shortfall = 1 - printed / pair_force(radius, ratio);
  CHECK(shortfall == Approx(0.077).epsilon(0.01));

  const double full_error = pair_errors(radius, ratio).force;
  const double printed_error = pair_errors(radius, ratio, Stress::normal_derivative).force;
  CHECK(full_error < 0.027);  // As in the test of convergence.
  CHECK(std::abs(printed_error - shortfall - full_error) < 0.027);
}

TEST_CASE("relaxation solver, gap of 0.8 spacings: capacitance within 33 %") {
  // The gap of 0.8 spacings (d / 2R = 1.05, R = 8) is too narrow for the lattice. The staircases are up to a spacing
  // farther apart; with C ~ gap^(-1/2) the error is 1 - sqrt(0.8 / 1.8) = 33 %. Contours through the other disk would
  // lose flux as well: 41 % without the correction.
  const LaplaceProblem problem = pair_in_plane(8, 1.05, 128, {0.3, 0.4});
  RelaxationSolver solver({.sites = 128});
  const LaplaceSolution solution = solver.solve(problem);
  CHECK(1 / (solution.group_potential[0] - problem.groups[1].potential) ==
        Approx(pair_capacitance(1.05)).epsilon(0.33));
}

TEST_CASE("relaxation solver: charges of a floating group sum to the given one") {
  LaplaceProblem problem = neutral_quartet();
  problem.sides[bottom] = electrode(0);
  RelaxationSolver solver({.sites = 64, .tolerance = 1e-7});
  const LaplaceSolution solution = solver.solve(problem);
  CHECK(solution.residual <= 1e-7);
  CHECK(solution.body_charge[0] == Approx(1).epsilon(1e-7));
  CHECK(solution.body_charge[1] == Approx(-0.25).epsilon(4e-7));
  CHECK(solution.body_charge[2] + solution.body_charge[3] == Approx(-0.75).epsilon(2e-7));
}

TEST_CASE("relaxation solver: descent error decays as (1 - eta C)^2 per step") {
  // d / 2R = 4, eta = 0.01, insulating walls (figure 6.6). A step multiplies the charge defect by 1 - eta C with the
  // scheme's capacitance C, so the rate is -2 ln(1 - eta C). The 2 eta C of D 6.39 is lower by eta C / 2 = 0.9 % of it.
  const double eta = 0.01;
  const LaplaceProblem problem = floating_near_grounded();
  RelaxationSolver solver({.sites = 128, .eta = eta});
  const LaplaceSolution solution = solver.solve(problem);
  const double capacitance = 1 / solution.group_potential[0];

  const std::vector<double>& error = solver.error_history();
  REQUIRE(error.size() > 300);
  const int first = 20, last = 300;
  const double rate = std::log(error[first] / error[last]) / (last - first);
  // Every potential solve leaves some of the last step's charge in the fluid, here less than 1e-3 of the defect.
  CHECK(rate == Approx(-2 * std::log(1 - eta * capacitance)).epsilon(1e-3));
  CHECK(rate == Approx(2 * eta * capacitance).epsilon(0.01));
}

TEST_CASE("relaxation solver: descent diverges 5 % above 2 / C, converges below") {
  // The bound requires converged potential solves: 40 n10 sweeps instead of 4 n10.
  const LaplaceProblem problem = floating_near_grounded();
  const double critical = 2 * RelaxationSolver({.sites = 128}).solve(problem).group_potential[0];  // 2 / C with Q = 1.
  RelaxationOptions options = {.sites = 128, .sweeps_factor = 40, .largest_iterations = 150};
  options.eta = 0.95 * critical;
  CHECK_NOTHROW(RelaxationSolver(options).solve(problem));  // 0.9^n < 1e-4 at n = 88
  options.eta = 1.05 * critical;
  CHECK_THROWS_AS(RelaxationSolver(options).solve(problem), Failure);
}

TEST_CASE("relaxation solver: the chosen descent step halves the solves") {
  LaplaceProblem problem = neutral_quartet();
  problem.sides[bottom] = electrode(0);
  RelaxationSolver chosen({.sites = 64}), constant({.sites = 64, .eta = 0.1});
  CHECK(2 * chosen.solve(problem).iterations < constant.solve(problem).iterations);
}

TEST_CASE("relaxation solver: first error is half the sum of squared charges") {
  LaplaceProblem problem = neutral_quartet();
  problem.sides[bottom] = electrode(0);
  RelaxationSolver solver({.sites = 64});
  solver.solve(problem);
  CHECK(solver.error_history().front() == Approx(0.5 * (1 + 0.25 * 0.25 + 0.75 * 0.75)));
}

TEST_CASE("relaxation solver: a group of given potential balances the charges") {
  LaplaceProblem problem = neutral_quartet();
  problem.groups[1] = {.floating = false, .potential = -2};
  RelaxationSolver solver({.sites = 64});
  const LaplaceSolution solution = solver.solve(problem);
  CHECK(solution.group_potential[1] == -2);
  // There is no other ground: the unbalanced field lines of +1 and -0.75 end there. The integrals are not conservative;
  // their sum has an error of 1 % at R = 4 spacings.
  CHECK(solution.body_charge[1] == Approx(-0.25).epsilon(0.04));
}

TEST_CASE("relaxation solver, insulated box: mean potential is zero") {
  RelaxationSolver solver({.sites = 64, .tolerance = 1e-6});
  const LaplaceSolution solution = solver.solve(neutral_quartet());
  const std::vector<double>& v = solution.group_potential;
  CHECK(std::abs(v[0] + v[1] + 2 * v[2]) < 1e-12);
  const std::vector<double>& q = solution.body_charge;
  const double common = q[0] - 1;
  CHECK(std::abs(common) < 0.01);
  CHECK(q[1] + 0.25 == Approx(common).epsilon(2e-6));
  CHECK(q[2] + q[3] + 0.75 == Approx(common).epsilon(2e-6));
}

TEST_CASE("relaxation solver, antisymmetric pair: opposite potentials and forces") {
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {64, 32};
  problem.bodies = {{Disk{{20.3, 16.4}, 5}, 0},
                    {Disk{{43.7, 16.4}, 5}, 1}};  // Mirror images in x = 32, a line of sites.
  problem.groups = {{.charge = 2}, {.charge = -2}};
  RelaxationSolver solver({.sites = 64, .tolerance = 1e-8});
  const LaplaceSolution solution = solver.solve(problem);
  CHECK(solution.group_potential[0] > 0);
  CHECK(solution.group_potential[1] == Approx(-solution.group_potential[0]).epsilon(1e-7));
  const Vec2 force = solution.body_force[0];
  CHECK(force.x > 0);  // The disks attract each other.
  CHECK(norm(solution.body_force[1] - Vec2{-force.x, force.y}) < 1e-6 * force.x);
}

TEST_CASE("relaxation solver: mirrored members share a group's charge equally") {
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {64, 64};
  problem.sides[bottom] = electrode(0);
  problem.bodies = {{Disk{{14, 40}, 5}, 0}, {Disk{{50, 40}, 5}, 0}, {Disk{{32, 20}, 4}, 1}};
  problem.groups = {{.charge = 3}, {.charge = 0}};
  RelaxationSolver solver({.sites = 64, .tolerance = 1e-7});
  const LaplaceSolution solution = solver.solve(problem);
  CHECK(solution.body_charge[0] == Approx(1.5).epsilon(1e-6));
  CHECK(solution.body_charge[1] == Approx(1.5).epsilon(1e-6));
  CHECK(std::abs(solution.body_charge[2]) < 3e-7);
  // The side takes the rest. Its flux is the lattice's and the group's is the integral, with 1 % difference at R = 5.
  CHECK(solution.side_charge[bottom] == Approx(-3).epsilon(0.02));
}

TEST_CASE("relaxation solver, disk in a ring: C = 2 pi eps / ln(b / a)") {
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {129, 129};
  problem.bodies = {{Disk{{64.5, 64.5}, 20}, 0}, {Ring{{64.5, 64.5}, 60}, 1}};
  problem.groups = {{.charge = 1}, {.floating = false, .potential = 0}};
  RelaxationSolver solver({.sites = 129, .tolerance = 1e-7});
  const LaplaceSolution solution = solver.solve(problem);
  // Both surfaces are shifted by at most half a spacing: ln 3 changes by 0.5 / 20 + 0.5 / 60 = 0.033, 3 %.
  CHECK(1 / solution.group_potential[0] == Approx(2 * pi / std::log(3.0)).epsilon(0.03));
  CHECK(solution.body_charge[1] == Approx(-1).epsilon(0.01));
  // The force vanishes by symmetry up to the relaxation's charge error in the disk's field 1 / (2 pi 20).
  CHECK(norm(solution.body_force[0]) < 1e-7 / (2 * pi * 20));
}

TEST_CASE("relaxation solver: disk cut by an insulating wall has half the charge") {
  LaplaceProblem whole{.permittivity = 1};
  whole.size = {64, 64};
  whole.bodies = {{Disk{{32, 32}, 10}, 0}, {Ring{{32, 32}, 28}, 1}};
  whole.groups = {{.floating = false, .potential = 1}, {.floating = false, .potential = 0}};
  RelaxationSolver solver({.sites = 64, .tolerance = 1e-8});
  const LaplaceSolution all = solver.solve(whole);

  struct Half {
    Vec2 size, centre, inward;
  };
  for (const auto& [size, centre, inward] : {Half{{64, 32}, {32, 0}, {0, 1}}, Half{{64, 32}, {32, 32}, {0, -1}},
                                             Half{{32, 64}, {0, 32}, {1, 0}}, Half{{32, 64}, {32, 32}, {-1, 0}}}) {
    LaplaceProblem half = whole;
    half.size = size;
    half.bodies = {{Disk{centre, 10}, 0}, {Ring{centre, 28}, 1}};
    const LaplaceSolution part = solver.solve(half);
    // The lattice is mirrored in a line of sites. Where the contour meets the wall its quadrature has a kink: one of
    // 250 points is counted in an oblique direction, 0.4 %.
    CHECK(part.body_charge[0] == Approx(0.5 * all.body_charge[0]).epsilon(4e-3));
    CHECK(part.energy == Approx(0.5 * all.energy).epsilon(1e-6));
    CHECK(dot(part.body_force[0], inward) > 0);  // The remaining half is attracted into the box.
    CHECK(std::abs(cross(part.body_force[0], inward)) < 0.01 * dot(part.body_force[0], inward));
  }
}

TEST_CASE("relaxation solver, insulated: capacitance matrix symmetric, zero rows") {
  RelaxationSolver solver({.sites = 64, .tolerance = 1e-6});
  const std::vector<double> c = capacitance_matrix(solver, neutral_quartet());
  for (int i = 0; i < 3; ++i) {
    // With all groups at 1 V there is no field.
    CHECK(std::abs(c[3 * i] + c[3 * i + 1] + c[3 * i + 2]) < 1e-4 * c[4 * i]);
    for (int j = 0; j < i; ++j) CHECK(c[3 * i + j] == Approx(c[3 * j + i]).epsilon(0.02));
  }
}

TEST_CASE("relaxation solver: last potentials are the next initial guess") {
  LaplaceProblem problem = neutral_quartet();
  problem.sides[top] = electrode(1);
  RelaxationSolver solver({.sites = 64});
  const LaplaceSolution cold = solver.solve(problem);
  CHECK(cold.iterations > 3);
  CHECK(solver.solve(problem).iterations == 1);

  // Regrouping keeps the bodies' potentials: the two parts of a split group start at the same potential.
  LaplaceProblem split = problem;
  split.bodies[3].group = 3;
  split.groups.push_back({.floating = false, .potential = cold.group_potential[2]});
  split.groups[2].charge = cold.body_charge[2];
  CHECK(solver.solve(split).iterations <= 2);

  solver.forget();
  const LaplaceSolution again = solver.solve(problem);
  CHECK(again.iterations == cold.iterations);
  CHECK(again.group_potential == cold.group_potential);
}

TEST_CASE("relaxation solver without charges: one iteration suffices") {
  LaplaceProblem problem = neutral_quartet();
  for (Group& group : problem.groups) group.charge = 0;
  RelaxationSolver solver({.sites = 64});
  const LaplaceSolution solution = solver.solve(problem);
  CHECK(solution.iterations == 1);
  CHECK(solution.residual == 0);
  CHECK(solution.energy == 0);
}

TEST_CASE("RelaxationSolver::field: contains the bodies with their potentials") {
  RelaxationSolver solver({.sites = 64});
  const LaplaceSolution solution = solver.solve(neutral_quartet());
  const Field field = solver.field();
  CHECK(field.h == 1);
  CHECK(field.body[17 * 64 + 14] == 0);  // Centre of disk 0.
  CHECK(field.value[17 * 64 + 14] == solution.group_potential[0]);
  CHECK(field.body[48 * 64 + 13] == 3);  // Member of group 2.
  CHECK(field.value[48 * 64 + 13] == solution.group_potential[2]);
  CHECK(field.body[0] == -1);
}

TEST_CASE("relaxation solver: an impossible problem is refused") {
  LaplaceProblem problem = neutral_quartet();
  RelaxationSolver solver({.sites = 64});
  SUBCASE("a malformed problem") { problem.groups[0].charge = 5; }
  SUBCASE("a box that is not a whole number of spacings high") { problem.size.y = 40.5; }
  SUBCASE("a body that covers no site") { problem.bodies[3].shape = Disk{{13.5, 48.5}, 0.6}; }
  SUBCASE("a body outside the box") { problem.bodies[3].shape = Disk{{80, 48}, 3}; }
  CHECK_THROWS_AS(solver.solve(problem), InputError);
}

TEST_CASE("RelaxationOptions: values out of range are refused") {
  CHECK_THROWS_AS(RelaxationSolver({.sites = 8}), InputError);
  CHECK_THROWS_AS(RelaxationSolver({.eta = -1}), InputError);
  CHECK_THROWS_AS(RelaxationSolver({.surface_points = 4}), InputError);
  CHECK_THROWS_AS(RelaxationSolver({.sweeps_factor = 0}), InputError);
  CHECK_THROWS_AS(RelaxationSolver({.tolerance = 0}), InputError);
  CHECK_THROWS_AS(RelaxationSolver({.largest_iterations = 0}), InputError);
}

TEST_CASE("RelaxationSolver::field before a solve: throws Failure") {
  RelaxationSolver solver({.sites = 64});
  CHECK_THROWS_AS(solver.field(), Failure);
}

TEST_CASE("relaxation solver: too few iterations throw Failure") {
  RelaxationSolver solver({.sites = 64, .largest_iterations = 2});
  CHECK_THROWS_AS(solver.solve(neutral_quartet()), Failure);
}

}  // namespace relaxation_test
