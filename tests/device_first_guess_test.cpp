// Tests of initial guesses of the device's solver, executed by the CPU item by item, against the CPU's.

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "solvers/laplace/cutcell/closest_shares.hpp"
#include "solvers/laplace/cutcell/device/cutcell.hpp"
#include "solvers/laplace/cutcell/device/follow.hpp"
#include "solvers/laplace/cutcell/device/multigrid.hpp"
#include "solvers/laplace/cutcell/follow.hpp"
#include "solvers/laplace/cutcell/history.hpp"
#include "solvers/laplace/cutcell/level_builder.hpp"
#include "solvers/laplace/cutcell/multigrid.hpp"
#include "solvers/laplace/cutcell/operator.hpp"
#include "solvers/parallel/host_executor.hpp"
#include "tests/device_scenes.hpp"

namespace device_first_guess_test {

using namespace lichtenberg;
using namespace lichtenberg::laplace;
using namespace lichtenberg::laplace::device_scenes;

namespace {

/// Problem after group `from` merges with group `into`, which precedes it.
LaplaceProblem with_merged(LaplaceProblem problem, int into, int from) {
  problem.groups[into].charge += problem.groups[from].charge;
  problem.groups.erase(problem.groups.begin() + from);
  for (Body& body : problem.bodies) {
    if (body.group == from) body.group = into;
    if (body.group > from) --body.group;
  }
  return problem;
}

/// Random values of the unknowns, zero elsewhere.
std::vector<double> random_unknowns(const CutCellOperator& op, random_placement::Random& random) {
  std::vector<double> x(op.size());
  for (double& value : x) value = random(-1, 1);
  op.mask(x.data());
  return x;
}

/// Solution on a grid in the device's form, with the given number of bodies.
struct KnownPotentials {
  KnownPotentials(const Potentials& found, double scale_)
      : layout(found.nx, found.ny), body(found.body), scale(scale_) {
    cell.resize(layout.size());
    for (int j = 0; j < found.ny; ++j)
      for (int i = 0; i < found.nx; ++i) cell[layout(i, j)] = found.cell[j * found.nx + i] / scale;
    for (double& value : body) value /= scale;
  }
  device::CoarseSolution view() { return {layout, static_cast<int>(body.size()), {cell.data(), body.data()}, scale}; }
  Layout layout;
  std::vector<double> cell, body;
  double scale;
};

/// System on the finest grid with the CPU's V-cycle, which has one sweep on coarse grids as the device's.
struct FinestSystem {
  FinestSystem(const LaplaceProblem& problem, int nx, int ny)
      : level(problem, nx, ny), multigrid(LinkFormula::log_fitted, parallel::Team::single(), 1) {
    LevelBuilder().build(problem, LinkFormula::log_fitted, level);
    op.build(problem, level);
    multigrid.prepare(problem, level.layout);
    multigrid.build_coarse(problem, level);
    multigrid.build_finest(problem, level);
    multigrid.finish();
    b.resize(op.size());
    op.right_hand_side(problem, b.data(), 1);
  }
  double product(const std::vector<double>& x, const std::vector<double>& y) const {
    return std::inner_product(x.begin(), x.end(), y.begin(), 0.0);
  }
  /// Solution by stationary iteration with the V-cycle.
  std::vector<double> solution() {
    std::vector<double> x(op.size(), 0.0), r(op.size()), z(op.size());
    for (int iteration = 0; iteration < 60; ++iteration) {
      op.apply(x.data(), r.data());
      for (std::size_t k = 0; k < r.size(); ++k) r[k] = b[k] - r[k];
      multigrid.apply(r.data(), z.data());
      for (std::size_t k = 0; k < r.size(); ++k) x[k] += z[k];
    }
    return x;
  }
  /// Error of x in the energy norm, relative to the solution `exact`.
  double error(std::vector<double> x, const std::vector<double>& exact) const {
    std::vector<double> image(op.size());
    op.apply(exact.data(), image.data());
    const double energy = product(exact, image);
    for (std::size_t k = 0; k < x.size(); ++k) x[k] -= exact[k];
    op.mask(x.data());
    op.apply(x.data(), image.data());
    return std::sqrt(product(x, image) / energy);
  }
  Level level;
  CutCellOperator op;
  Multigrid multigrid;
  std::vector<double> b;
};

/// Guess by nested iteration on the device's grids.
std::vector<double> nested_guess_of_device(const LaplaceProblem& problem, int nx, int ny, std::size_t size) {
  parallel::HostExecutor run;
  device::DeviceProblem<parallel::HostExecutor> on_device(run);
  device::DeviceMultigrid<parallel::HostExecutor> multigrid(run, problem, nx, ny, LinkFormula::log_fitted);
  on_device.upload(problem, nx, ny);
  multigrid.build(problem, on_device.view());
  REQUIRE(multigrid.has_nested_guess());
  std::vector<double> x(std::max(size, multigrid.finest().view().layout.size() + std::size_t(on_device.view().groups)));
  multigrid.nested_guess(1, x.data());
  x.resize(size);
  return x;
}

}  // namespace

TEST_CASE("device cold start: nested guess is as good as the CPU's") {
  LaplaceProblem problem = random_disks(25, 0.6);
  for (const bool sides : {false, true}) {
    if (sides) {
      // Given potentials of sides and of a disk; coarse grids absorb the other disks successively.
      problem.sides[left].kind = problem.sides[right].kind = Side::Kind::electrode;
      problem.sides[right].profile = [&](Vec2 p) { return 1 + p.y / problem.size.y; };
      problem.groups[3] = {false, 0, -1};
    }
    FinestSystem system(problem, 384, 256);
    const std::vector<double> exact = system.solution();
    std::vector<double> on_cpu(system.op.size());
    system.multigrid.nested_guess(problem, 1, on_cpu.data());
    const double cpu = system.error(on_cpu, exact);
    const double error = system.error(nested_guess_of_device(problem, 384, 256, system.op.size()), exact);
    MESSAGE("error of the guess: ", error, ", of the CPU's ", cpu);
    // The device starts with one V-cycle from zero, which leaves about 1/6 of the error on the first of the small
    // grids.
    CHECK(error < 1.25 * cpu);
    CHECK(error < 0.1);
  }
}

TEST_CASE("device initial guess from a coarser grid: equals the CPU's") {
  const LaplaceProblem problem = with_merged(random_disks(25, 0.6), 3, 7);
  const int nx = 96, ny = 64, bodies = static_cast<int>(problem.bodies.size());
  Level level(problem, nx, ny);
  LevelBuilder().build(problem, LinkFormula::log_fitted, level);
  CutCellOperator op;
  op.build(problem, level);
  random_placement::Random random(5);
  const auto some = [&](std::size_t n) {
    std::vector<double> values(n);
    for (double& value : values) value = random(-3, 3);
    return values;
  };
  // Coarse solutions are in V, the finer one's potentials in units of 2 V.
  const double scale = 2;
  const Potentials before{24, 16, some(24 * 16), some(bodies)}, now{24, 16, some(24 * 16), some(bodies)};
  SolutionHistory history;
  std::vector<double> newest = random_unknowns(op, random);
  const std::vector<double> body_potentials = some(bodies);
  std::vector<double> past_cell(newest.begin(), newest.begin() + level.layout.size()), past_body = body_potentials;
  for (const std::ptrdiff_t slot : level.covered) past_cell[slot] = past_body[level.owner[slot].body()];
  for (const std::ptrdiff_t slot : level.covered) newest[slot] = past_cell[slot];
  history.store(newest, body_potentials);
  std::vector<double> x(op.size());
  history.newest_as_guess(problem, op, x);
  add_change(before, now, problem, scale, op, x);

  parallel::HostExecutor run;
  device::DeviceProblem<parallel::HostExecutor> on_device(run);
  on_device.upload(problem, nx, ny);
  device::DeviceMultigrid<parallel::HostExecutor> grids(run, problem, nx, ny, LinkFormula::log_fitted);
  grids.build(problem, on_device.view());
  device::Follower<parallel::HostExecutor> follower(run);
  KnownPotentials then(before, 7), later(now, 0.3);  // The units of the solutions are arbitrary.
  follower.keep(then.view());
  REQUIRE(follower.is_comparable(later.view()));
  follower.compare(later.view(), scale);
  std::vector<double> device_x(op.size(), -7.0);
  device::follow_change(run, on_device.view(), grids.finest().view(), {past_cell.data(), past_body.data()},
                        follower.change(), device_x.data());
  // Weights in single precision with the sum 1, for changes of at most 6 V.
  for (std::size_t k = 0; k < op.size(); ++k) REQUIRE(std::abs(device_x[k] - x[k]) <= 6 / scale * 0x1p-24 + 1e-14);
}

TEST_CASE("closest_shares: error is orthogonal to the basis, also a dependent one") {
  // Vectors in the metric diag(1, 2, 3, 4); the third is the sum of the others, or independent.
  constexpr int n = 4, m = history_length;
  const std::array<double, n> exact{1, -2, 0.5, 3};
  for (const bool dependent : {true, false}) {
    CAPTURE(dependent);
    std::array<std::array<double, n>, m> v{{{1, 2, -1, 0.5}, {0.3, -1, 2, 1}, {0, 1, 1, -2}}};
    for (int k = 0; k < n && dependent; ++k) v[2][k] = v[0][k] + v[1][k];
    GuessProducts products;
    for (int p = 0; p < m; ++p)
      for (int k = 0; k < n; ++k) {
        products.rhs[p] += v[p][k] * (k + 1) * exact[k];
        for (int q = 0; q <= p; ++q) products.gram[p][q] += v[p][k] * (k + 1) * v[q][k];
      }
    const Shares share = closest_shares(products, m);
    for (int p = 0; p < m; ++p) {
      double product = 0;  // Product of the error with a basis vector.
      for (int k = 0; k < n; ++k) {
        double guess = 0;
        for (int q = 0; q < m; ++q) guess += share.of[q] * v[q][k];
        product += v[p][k] * (k + 1) * (exact[k] - guess);
      }
      // 300 roundings of products below 30, as a random walk: 30 x 1.1e-16 x sqrt(300) = 6e-14.
      CHECK(std::abs(product) < 1e-13);
    }
    CHECK(std::ranges::count(share.of, 0.0) == (dependent ? 1 : 0));
  }
}

TEST_CASE("device::Follower: needs an earlier solution with equally many bodies") {
  parallel::HostExecutor run;
  device::Follower<parallel::HostExecutor> follower(run);
  KnownPotentials two({8, 8, std::vector<double>(64), {1, 2}}, 1), one({8, 8, std::vector<double>(64), {1}}, 1);
  CHECK_FALSE(follower.is_comparable({}));
  CHECK_FALSE(follower.is_comparable(two.view()));
  follower.keep(two.view());
  CHECK(follower.is_comparable(two.view()));
  CHECK_FALSE(follower.is_comparable(one.view()));
  CHECK_FALSE(follower.is_comparable({}));
  follower.keep({});
  CHECK_FALSE(follower.is_comparable(two.view()));
}

TEST_CASE("device initial guess from a coarser grid: saves iterations at merges") {
  CutCellOptions fine, coarse;
  fine.cells = 192;
  fine.tolerance = 1e-5;
  coarse.cells = 48;
  coarse.tolerance = 1e-4;
  const auto leader = device::make_host_solver(coarse), following = device::make_host_solver(fine),
             alone = device::make_host_solver(fine);
  CutCellSolver cpu_leader(coarse), cpu(fine);
  following->follow(*leader);
  cpu.follow(cpu_leader);
  LaplaceProblem problem = random_disks(25, 0.6);
  int with = 0, without = 0, on_cpu = 0;
  for (int step = 0; step < 8; ++step) {
    leader->solve(problem);
    cpu_leader.solve(problem);
    const int following_iterations = following->solve(problem).iterations,
              alone_iterations = alone->solve(problem).iterations, cpu_iterations = cpu.solve(problem).iterations;
    if (step == 0) {
      CHECK(following_iterations == alone_iterations);
    } else {
      with += following_iterations;
      without += alone_iterations;
      on_cpu += cpu_iterations;
    }
    problem = with_merged(problem, 1 + step, 4 + step);
    for (std::size_t body = 1; body < problem.bodies.size(); ++body)
      std::get<Disk>(problem.bodies[body].shape).centre += Vec2{0.002, -0.003};
  }
  MESSAGE("iterations of 7 solves: ", with, ", not following ", without, ", the CPU's ", on_cpu);
  CHECK(with < without);
  CHECK(with <= on_cpu + 7);  // Coarse grids use one sweep here: at most one more iteration each.

  // The solution does not depend on following: single potentials agree to 2e-8 (see device_test).
  following->set_tolerance(1e-10);
  cpu.set_tolerance(1e-10);
  leader->solve(problem);
  const std::vector<double> found = following->solve(problem).group_potential,
                            expected = cpu.solve(problem).group_potential;
  double largest = 0;
  for (const double potential : expected) largest = std::max(largest, std::abs(potential));
  for (std::size_t g = 0; g < expected.size(); ++g) CHECK(std::abs(found[g] - expected[g]) < 2e-8 * largest);
}

}  // namespace device_first_guess_test
