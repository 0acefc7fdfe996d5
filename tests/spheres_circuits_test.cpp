// Tests of resistors between groups of spheres and to supplies: couplings of the field within a step.
#include <doctest/doctest.h>

#include <Eigen/Dense>
#include <cmath>

#include "solvers/laplace/spheres/spheres.hpp"

namespace spheres_circuits_test {

using namespace lichtenberg;
using namespace lichtenberg::laplace;

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

/// Problem of three floating spheres, two of them in group 1, one sphere at 2 V, and a supply of 5 V without spheres.
/// The couplings are 0 to the supply, 0 to 1, and 1 to the sphere at 2 V.
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

TEST_CASE("spheres with lumped conductances: agree with the capacitance matrix") {
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
      // Potentials of a few volts within the accuracy; the elimination loses 1e-16 times the strength.
      for (int g = 0; g < 4; ++g) CHECK(std::abs(solution.group_potential[g] - expected[g]) < 1e-8);
      std::vector<double> left;
      for (const Group& group : problem.groups) left.push_back(group.charge);
      for (std::size_t k = 0; k < problem.couplings.size(); ++k) {
        const auto& [a, b, capacitance] = problem.couplings[k];
        left[a] -= solution.coupling_charge[k], left[b] += solution.coupling_charge[k];
        const double difference = solution.group_potential[a] - solution.group_potential[b];
        // An error of the potentials within the accuracy changes the transferred charge, and rounding times the
        // strength.
        CHECK(std::abs(solution.coupling_charge[k] - capacitance * difference) < capacitance * 1e-8);
      }
      for (std::size_t i = 0; i < problem.spheres.size(); ++i)
        left[problem.spheres[i].group] -= solution.sphere_charge[i];
      // Rounding of the charges, and of the charge that flows from 5 V to 2 V through all: below the strength.
      for (int g = 0; g < 2; ++g) CHECK(std::abs(left[g]) < 1e-14 + 1e-15 * strength);
    }
    CHECK(most <= least + 4);
  }
}

TEST_CASE("lumped conductance between spheres: 1e9 is a wire, zero is none") {
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

TEST_CASE("lumped conductance of a sphere to a source: 1e5 to 1e300 are wires") {
  SphereProblem problem{.free_space = true, .permittivity = 4.2e-11};
  problem.groups = {{.charge = 2e-10}, {.charge = 0}, {.floating = false, .potential = 100}};
  problem.spheres = {{{0.003, 0.005, 0.005}, 7.75e-4, 0}, {{0.005, 0.008, 0.005}, 5e-4, 1}};
  for (const double capacitance : {1e5, 1e27, 1e200, 1e300}) {
    problem.couplings = {{1, 2, capacitance}};
    CHECK(SphereSolver({.accuracy = 1e-9}).solve(problem).group_potential[1] == doctest::Approx(100).epsilon(1e-9));
  }
}

TEST_CASE("sphere solution history: saves 30 % of iterations in a moving circuit") {
  SphereSolver solver({.accuracy = 1e-8});
  SphereProblem problem = coupled_spheres(true, 0.01);  // 1 % of the coupling that charges a sphere within a step.
  int warm = 0;
  for (int step = 1; step <= 6; ++step) {
    const SphereSolution solution = solver.solve(problem);
    warm = solution.iterations;
    for (std::size_t k = 0; k < problem.couplings.size(); ++k) {
      problem.groups[problem.couplings[k].a].charge -= solution.coupling_charge[k];
      problem.groups[problem.couplings[k].b].charge += solution.coupling_charge[k];
    }
    problem.spheres[0].centre.x += 1e-4;
    for (Coupling& coupling : problem.couplings) coupling.capacitance *= 1.05;  // Longer steps.
  }
  solver.forget();
  CHECK(warm < 0.7 * solver.solve(problem).iterations);
}

}  // namespace spheres_circuits_test
