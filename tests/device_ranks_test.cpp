// Tests of fields on several devices: threads of the CPU execute the kernels of the ranks.

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "solvers/error.hpp"
#include "solvers/laplace/cutcell/device/device.hpp"
#include "solvers/laplace/cutcell/device/multigrid.hpp"
#include "tests/device_scenes.hpp"

namespace device_ranks_test {

using namespace lichtenberg;
using namespace lichtenberg::laplace;
using namespace lichtenberg::laplace::device_scenes;

namespace {

/// Largest difference of potentials, charges and forces from those of `a`, relative to the largest values there.
double difference(const LaplaceSolution& a, const LaplaceSolution& b) {
  double worst = std::abs(b.energy / a.energy - 1);
  const auto compare = [&](const auto& x, const auto& y, auto magnitude) {
    double largest = 0, change = 0;
    REQUIRE(x.size() == y.size());
    for (std::size_t k = 0; k < x.size(); ++k) {
      largest = std::max(largest, magnitude(x[k]));
      change = std::max(change, magnitude(x[k] - y[k]));
    }
    if (largest > 0) worst = std::max(worst, change / largest);
  };
  const auto absolute = [](double value) { return std::abs(value); };
  compare(a.group_potential, b.group_potential, absolute);
  compare(a.body_charge, b.body_charge, absolute);
  compare(a.side_charge, b.side_charge, absolute);
  compare(a.body_force, b.body_force, [](Vec2 force) { return norm(force); });
  return worst;
}

/// Problem in a box of 96 x 96. A bar and a large disk lie across the borders of two and of three ranks. Some disks are
/// too small for coarse grids.
LaplaceProblem across_borders() {
  LaplaceProblem problem{.permittivity = 2};
  problem.size = {96, 96};
  problem.sides[top] = {Side::Kind::electrode, 0.3, {}};
  problem.bodies = {{Bar{{20, 14}, {24, 80}, 1.2}, 1}, {Disk{{60, 48}, 19}, 2}, {Disk{{48, 0}, 7}, 0}};
  problem.groups = {{false, 0, 0.1}, {true, 0.4, 0}, {true, -0.7, 0}};
  for (int k = 0; k < 40; ++k) {
    problem.bodies.push_back({Disk{{4.0 + k % 5 * 2.1, 3.3 + 11.2 * (k / 5)}, k % 3 == 0 ? 0.35 : 0.8},
                              static_cast<int>(problem.groups.size())});
    problem.groups.push_back({true, 0.05 * (k % 7 - 3), 0});
  }
  return problem;
}

/// Problem with couplings, of which one leads to ground.
LaplaceProblem coupled() {
  LaplaceProblem problem = across_borders();
  problem.couplings = {{1, 2, 3.0}, {2, 5, 0.4}, {5, 0, 10.0}};
  return problem;
}

/// Problem with pairs of disks across the borders of two and three ranks, with gaps of 1e-6 of their radius.
LaplaceProblem chains() {
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {96, 96};
  problem.sides[left] = {Side::Kind::electrode, 1, {}};
  for (int k = 0; k < 12; ++k) {
    problem.bodies.push_back({Disk{{30.3 + 30 * (k / 6), 25 + 8.000008 * (k % 6)}, 4}, k});
    problem.groups.push_back({true, 1.0 + k % 3, 0});
  }
  return problem;
}

/// Problem without ground whose charges sum to zero.
LaplaceProblem without_ground() {
  LaplaceProblem problem = across_borders();
  problem.sides = {};
  double total = 0;
  problem.groups[0].floating = true;
  for (const Group& group : problem.groups) total += group.charge;
  problem.groups[0].charge = -total;
  return problem;
}

void move(LaplaceProblem& problem) {
  for (Body& body : problem.bodies)
    if (auto* disk = std::get_if<Disk>(&body.shape)) disk->centre += Vec2{0.013, -0.007};
}

struct Named {
  const char* name;
  LaplaceProblem problem;
};
std::vector<Named> problems() {
  return {{"across borders", across_borders()},
          {"coupled", coupled()},
          {"chains", chains()},
          {"without ground", without_ground()}};
}

/// Compares solves by two and three ranks with those of one device while the bodies move.
void compare_ranks(int steps) {
  CutCellOptions options;
  options.cells = 384;
  options.tolerance = 1e-10;
  REQUIRE(device::divided_grids(grid_sizes(384, 384), 2, 1024) == 3);
  REQUIRE(device::divided_grids(grid_sizes(384, 384), 3, 1024) == 3);
  for (const auto& [name, start] : problems()) {
    CAPTURE(std::string(name));
    const auto one = device::make_host_solver(options);
    std::vector<LaplaceSolution> expected;
    LaplaceProblem moving = start;
    for (int step = 0; step < steps; ++step) {
      expected.push_back(one->solve(moving));
      move(moving);
    }
    const Field f = one->field();
    for (const int ranks : {2, 3}) {
      CAPTURE(ranks);
      const auto several = device::make_host_solver(options, ranks);
      LaplaceProblem problem = start;
      for (int step = 0; step < steps; ++step) {  // From the second step on, solves use the history.
        CAPTURE(step);
        const LaplaceSolution &a = expected[step], b = several->solve(problem);
        CHECK(b.unknowns == a.unknowns);
        // Ranks round differently in sums only. With wrong values in a ghost row the iterations would be more.
        CHECK(std::abs(b.iterations - a.iterations) <= 1);
        CHECK(difference(a, b) < 1e-8);  // as for one device and the CPU in device_test.cpp
        move(problem);
      }
      const Field g = several->field();
      CHECK(f.body == g.body);
      REQUIRE(f.value.size() == g.value.size());
      double worst = 0;
      for (std::size_t k = 0; k < f.value.size(); ++k) worst = std::max(worst, std::abs(f.value[k] - g.value[k]));
      CHECK(worst < 1e-8 * std::abs(*std::ranges::max_element(
                               f.value, {}, [](double v) { return std::abs(v); })));
    }
  }
}

}  // namespace

TEST_CASE("device ranks: potentials, charges and forces equal one device's") { compare_ranks(2); }

TEST_CASE("device ranks: five steps equal one device's" * doctest::test_suite("long")) { compare_ranks(5); }

TEST_CASE("device ranks: charges are exact to rounding at tolerance 1e-2") {
  CutCellOptions options;
  options.cells = 192;
  options.tolerance = 1e-2;
  for (const auto& [name, problem] : problems()) {
    CAPTURE(std::string(name));
    const LaplaceSolution found = device::make_host_solver(options, 2)->solve(problem);
    std::vector<double> charge(problem.groups.size(), 0.0);
    double sum = 0, largest = 0;
    for (std::size_t body = 0; body < problem.bodies.size(); ++body) {
      charge[problem.bodies[body].group] += found.body_charge[body];
      sum += found.body_charge[body];
      largest = std::max(largest, std::abs(found.body_charge[body]));
    }
    for (const double q : found.side_charge) sum += q;
    for (const laplace::Coupling& coupling : problem.couplings) {
      const double q = coupling.capacitance * (found.group_potential[coupling.a] - found.group_potential[coupling.b]);
      charge[coupling.a] += q;
      charge[coupling.b] -= q;
      largest = std::max(largest, std::abs(q));
    }
    // As in device_test.cpp.
    for (std::size_t g = 0; g < charge.size(); ++g)
      if (problem.groups[g].floating) CHECK(std::abs(charge[g] - problem.groups[g].charge) < 1e-11 * largest);
    CHECK(std::abs(sum) < 1e-11 * largest);
  }
}

TEST_CASE("device ranks: a solve repeats its bits") {
  CutCellOptions options;
  options.cells = 192;
  for (const int ranks : {2, 3}) {
    const auto first = device::make_host_solver(options, ranks), second = device::make_host_solver(options, ranks);
    const LaplaceSolution a = first->solve(across_borders()), b = second->solve(across_borders());
    CHECK(a.group_potential == b.group_potential);
    CHECK(a.body_charge == b.body_charge);
    CHECK(a.energy == b.energy);
  }
}

TEST_CASE("device ranks: nested iteration gives the guess of one device") {
  CutCellOptions options;
  options.cells = 1024;  // as many as it needs
  options.tolerance = 1e-3;
  const LaplaceSolution a = device::make_host_solver(options)->solve(across_borders());
  const LaplaceSolution b = device::make_host_solver(options, 2)->solve(across_borders());
  CHECK(b.iterations == a.iterations);
  CHECK(difference(a, b) < 100 * options.tolerance);  // as above
}

TEST_CASE("device ranks: a grid too small for them is refused") {
  CutCellOptions options;
  options.cells = 32;
  CHECK_THROWS_WITH_AS(
      device::make_host_solver(options, 2)->solve(across_borders()),
      "field.cells: a grid of 32 x 32 cells is too small for 2 devices: each needs at least 1024 cells", InputError);
}

}  // namespace device_ranks_test
