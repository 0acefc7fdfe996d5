#include <doctest/doctest.h>
#include <petscpc.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <set>
#include <thread>

#include "solvers/error.hpp"
#include "solvers/laplace/cutcell/follow.hpp"
#include "solvers/laplace/cutcell/level_builder.hpp"
#include "solvers/laplace/cutcell/link.hpp"
#include "solvers/laplace/cutcell/solver.hpp"
#include "solvers/parallel/petsc.hpp"
#include "tests/cutcell_problems.hpp"
#include "tests/message.hpp"

namespace cutcell_test {

using namespace lichtenberg;
using namespace lichtenberg::laplace;
using namespace lichtenberg::cutcell_problems;

namespace {

double total_charge(const LaplaceSolution& solution) {
  double sum = 0;
  for (const double q : solution.body_charge) sum += q;
  for (const double q : solution.side_charge) sum += q;
  return sum;
}

}  // namespace

TEST_CASE("two disks: capacitance and force match bipolar values at R = 8 cells") {
  // The bounds are the scheme's largest truncation errors over positions (validation/two_disks).
  struct Row {
    double ratio, potential, force;
  };
  for (const Row row : {Row{2, 2e-4, 1e-3}, Row{1.25, 1.5e-3, 6e-3}, Row{1.05, 1e-2, 3.5e-2}}) {
    CutCellSolver solver(options(128));
    const double R = 8, d = 2 * R * row.ratio, a = std::sqrt(0.25 * d * d - R * R);
    const Vec2 e{1, 0};
    const LaplaceSolution solution = solver.solve(two_disks(128, {64.3, 63.8}, e, R, d));
    const double phi = std::acosh(row.ratio) / pi, force = 1 / (4 * pi * a);
    CAPTURE(row.ratio);
    CHECK(std::abs(solution.group_potential[0] / phi - 1) < row.potential);
    CHECK(norm(solution.body_force[0] - force * e) < row.force * force);
    CHECK(norm(solution.body_force[1] + force * e) < row.force * force);
  }
}

TEST_CASE("Gauss's law: total charge is zero and each group keeps its charge") {
  LaplaceProblem problem = random_disks(12, 64, 5, 0.3);
  problem.groups[3].charge = 2.5;
  problem.bodies[12].group = 3;  // Two disks with one potential.
  problem.groups.pop_back();
  CutCellSolver solver(options(64));
  const LaplaceSolution solution = solver.solve(problem);
  CHECK(solution.body_charge[3] + solution.body_charge[12] == doctest::Approx(2.5).epsilon(1e-12));
  CHECK(std::abs(total_charge(solution)) < 1e-12);
}

TEST_CASE("chain of nearly touching disks: solved in fewer than 20 iterations") {
  // Gap conductances are some thousand times those of cells. The chain's common mode must enter the norm of CG.
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {256, 256};
  problem.sides[left] = {Side::Kind::electrode, 1, {}};
  for (int k = 0; k < 12; ++k) {
    problem.bodies.push_back({Disk{{20.2 + k * (16 + 1e-6), 60.3}, 8}, k});
    problem.groups.push_back({true, k == 0 ? 1.0 : 0.0, 0});
  }
  const double tolerance = 1e-8;
  CutCellOptions assembled = options(256, tolerance);
  assembled.linear_solver = CutCellOptions::LinearSolver::assembled;
  const LaplaceSolution a = CutCellSolver(options(256, tolerance)).solve(problem);
  const LaplaceSolution b = CutCellSolver(assembled).solve(problem);
  CHECK(a.iterations < 20);
  // The tolerance holds in the energy norm. It is scaled by the square root of a potential's energy per volt.
  for (int k = 0; k < 12; ++k)
    CHECK(a.group_potential[k] == doctest::Approx(b.group_potential[k]).epsilon(1000 * tolerance));
}

TEST_CASE("initial guess 1e5 times too large: conjugate gradients do not stop early") {
  // A group of two distant disks: one nearly touches the electrode, the other nearly touches a second group. The
  // initial guess from coarser grids is 1e5 times too large.
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {80, 80};
  problem.sides[bottom] = {Side::Kind::electrode, 0, {}};
  problem.groups = {{true, 0, 0}, {true, 0, 0}, {true, 3.4, 0}};
  problem.bodies = {{Disk{{30.2670257603, 38.9019172966}, 7.32570272483}, 0},
                    {Disk{{19.2041680051, 34.2340270928}, 4.6816228533}, 1},
                    {Disk{{61.6603819612, 6.87553686492}, 6.87471731906}, 0},
                    {Disk{{55.9806125476, 66.6786983088}, 3.7634746629}, 2}};
  CutCellOptions assembled = options(80, 1e-11);
  assembled.linear_solver = CutCellOptions::LinearSolver::assembled;
  const LaplaceSolution a = CutCellSolver(options(80, 1e-8)).solve(problem);
  const LaplaceSolution b = CutCellSolver(assembled).solve(problem);
  for (int g = 0; g < 3; ++g)
    CHECK(std::abs(a.group_potential[g] - b.group_potential[g]) < 1e-6 * b.group_potential[2]);
}

TEST_CASE("charges: exact to rounding for tolerance 1e-2 and adjacent conductors") {
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {64, 64};
  problem.sides[top] = {Side::Kind::electrode, 1, {}};
  problem.groups = {{false, 0, 0}, {true, 1, 0}, {true, -0.3, 0}, {true, 0.5, 0}, {true, -0.7, 0}};
  problem.bodies = {{Disk{{32, 0}, 8}, 0},
                    {Disk{{20, 30}, 6}, 1},
                    {Disk{{30.001, 30}, 4}, 2},
                    {Disk{{45, 58.999}, 5}, 3},
                    {Disk{{50, 20}, 5}, 4}};
  const LaplaceSolution solution = CutCellSolver(options(64, 1e-2)).solve(problem);
  // About 100 links with conductances up to about 100; each rounds a potential of about 1.
  constexpr double rounding = 1e-11;
  CHECK(std::abs(total_charge(solution)) < rounding);
  for (std::size_t b = 1; b < problem.bodies.size(); ++b)
    CHECK(std::abs(solution.body_charge[b] - problem.groups[b].charge) < rounding);
}

TEST_CASE("insulated box: mean potential is zero and a net charge is refused") {
  LaplaceProblem problem = random_disks(4, 64, 6, 4);
  problem.bodies.erase(problem.bodies.begin());
  problem.groups = {{true, 1, 0}, {true, -0.5, 0}, {true, -0.75, 0}, {true, 0.25, 0}};
  for (int k = 0; k < 4; ++k) problem.bodies[k].group = k;
  for (const auto linear_solver : {CutCellOptions::LinearSolver::multigrid, CutCellOptions::LinearSolver::assembled}) {
    CutCellOptions o = options(64);
    o.linear_solver = linear_solver;
    CutCellSolver solver(o);
    const LaplaceSolution solution = solver.solve(problem);
    double mean = 0;
    for (const double phi : solution.group_potential) mean += phi;
    CHECK(std::abs(mean) < 1e-12);
    for (int k = 0; k < 4; ++k)
      CHECK(solution.body_charge[k] == doctest::Approx(problem.groups[k].charge).epsilon(1e-8));
    CHECK(solution.energy > 0);
    // The constant that fixes the mean must not enter the next initial guess.
    LaplaceProblem grounded = problem;
    grounded.groups[3] = {false, 0, 0};
    const LaplaceSolution after = solver.solve(grounded);
    solver.forget();
    const LaplaceSolution alone = solver.solve(grounded);
    for (int k = 0; k < 4; ++k)
      CHECK(after.group_potential[k] == doctest::Approx(alone.group_potential[k]).epsilon(1e-8));
  }
  problem.groups[0].charge = 1.1;
  CutCellSolver solver(options(64));
  CHECK_THROWS_AS(solver.solve(problem), InputError);
}

TEST_CASE("assembled matrix: solution equals that of the matrix-free multigrid") {
  const LaplaceProblem problem = random_disks(12, 64, 5, 0.05);
  CutCellOptions o = options(64);
  CutCellSolver matrix_free(o);
  o.linear_solver = CutCellOptions::LinearSolver::assembled;
  CutCellSolver assembled(o);
  const LaplaceSolution a = matrix_free.solve(problem), b = assembled.solve(problem);
  for (std::size_t g = 0; g < a.group_potential.size(); ++g)
    CHECK(a.group_potential[g] == doctest::Approx(b.group_potential[g]).epsilon(1e-8));
}

TEST_CASE("force: equals the negative energy derivative for shifts of 1e-4 cells") {
  // With constant charges F = -dW/dx. A step of 1e-4 cells gives a truncation error of 1e-8. The relative solver error
  // of W is 1e-20 (square of the energy norm).
  LaplaceProblem problem = random_disks(6, 64, 6, 0.2);
  CutCellSolver solver(options(64, 1e-11));
  const LaplaceSolution solution = solver.solve(problem);
  double scale = 0;
  for (const Vec2 f : solution.body_force) scale = std::max(scale, norm(f));
  for (const int body : {1, 2, 3, 4, 5, 6})
    for (const Vec2 direction : {Vec2{1, 0}, Vec2{0, 1}}) {
      const double step = 1e-4;
      double energy[2];
      for (const int k : {0, 1}) {
        LaplaceProblem moved = problem;
        std::get<Disk>(moved.bodies[body].shape).centre += (k == 0 ? -step : step) * direction;
        energy[k] = solver.solve(moved).energy;
      }
      CHECK(dot(solution.body_force[body], direction) ==
            doctest::Approx(-(energy[1] - energy[0]) / (2 * step)).epsilon(1e-6).scale(scale));
    }
}

TEST_CASE("electrodes of every shape: potentials obey the maximum principle") {
  LaplaceProblem problem = random_disks(5, 64, 5, 8);
  problem.sides[left] = {Side::Kind::electrode, 2.0, {}};
  problem.sides[top] = {Side::Kind::electrode, -1.0, {}};
  problem.groups.push_back({false, 0, 1.5});
  problem.bodies.push_back({Bar{{6, 8}, {14, 20}, 0.3}, static_cast<int>(problem.groups.size()) - 1});
  problem.bodies.push_back({Ring{{32, 32}, 40}, 0});
  for (Group& group : problem.groups)
    if (group.floating) group.charge = 0;
  CutCellSolver solver(options(64));
  const LaplaceSolution solution = solver.solve(problem);
  const Field field = solver.field();
  for (const double v : field.value) {
    CHECK(v <= 2.0 + 1e-8);  // Solver tolerance.
    CHECK(v >= -1.0 - 1e-8);
  }
  CHECK(std::abs(total_charge(solution)) < 1e-7);
}

TEST_CASE("cell centres on surfaces, tiny disks: forces finite, total charge zero") {
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {64, 64};
  problem.groups = {{false, 0, 0}, {true, 1, 0}, {true, -1, 0}, {true, 1, 0}, {true, 0.5, 0}};
  problem.bodies = {{Disk{{32, 0}, 8}, 0},
                    {Disk{{20.5, 30.5}, 6}, 1},  // Cell centres lie exactly on the surface.
                    // Cell centres lie 1e-12 from the surface; the gap is 1e-9.
                    {Disk{{32.5 + 1e-9, 30.5}, 6 - 1e-12}, 2},
                    {Disk{{50.2, 50.7}, 0.05}, 3},
                    {Disk{{50.5, 20.5}, 1e-6}, 4}};
  CutCellSolver solver(options(64));
  const LaplaceSolution solution = solver.solve(problem);
  CHECK(std::abs(total_charge(solution)) < 1e-7);
  for (const Vec2 f : solution.body_force) CHECK(std::isfinite(norm(f)));
  // Disks in contact have the same potential.
  CHECK(solution.group_potential[1] == doctest::Approx(solution.group_potential[2]).epsilon(1e-2));
}

TEST_CASE("cell centre exactly on a surface: link conductance finite and positive") {
  // 13 = sqrt(5^2 + 12^2) and 5 = sqrt(3^2 + 4^2): twelve centres lie on the circle, except for rounding of the
  // lengths.
  for (const double side : {0.03, 0.0512, 0.07, 0.1})
    for (const double radius : {5.0, 13.0})
      for (int column = 20; column < 60; ++column)
        for (const LinkFormula formula : {LinkFormula::log_fitted, LinkFormula::plain}) {
          const double h = side / 100;
          LaplaceProblem problem{.permittivity = 1};
          problem.size = {side, side};
          problem.bodies = {{Disk{{(column + 0.5) * h, 30.5 * h}, radius * h}, 0}};
          problem.groups = {{true, 1, 0}};
          Level level(problem, 100, 100);
          LevelBuilder().build(problem, formula, level);
          bool positive = true;
          for (const FluidLink& link : level.links)
            positive = positive && link.conductance > 0 && std::isfinite(link.conductance) &&
                       std::isfinite(norm(link.gradient));
          CHECK(positive);
        }
}

TEST_CASE("surfaces 1e-6 to 1e-14 of a radius from cell centres: usual accuracy") {
  // Shrinking a disk by the fraction d of its radius changes its potential by about d Q / 2 pi.
  const auto lattice = [](double shrinkage) {
    const double h = 1e-4;
    LaplaceProblem problem{.permittivity = 1};
    problem.size = {160 * h, 160 * h};
    problem.sides[bottom] = {Side::Kind::electrode, 0, {}};
    for (int k = 0; k < 100; ++k) {
      const Vec2 centre{(16 * (k % 10) + 8.5) * h, (16 * (k / 10) + 8.5) * h};
      problem.bodies.push_back({Disk{centre, 5 * (1 - shrinkage) * h}, k});
      problem.groups.push_back({true, k % 2 ? 1.0 : -0.5, 0});
    }
    CutCellSolver solver(options(160, 1e-8));
    return solver.solve(problem);
  };
  const LaplaceSolution usual = lattice(1e-6);
  // Cells with newly covered centres have links of other lengths, which changes the truncation error at R = 5 cells.
  const double truncation = 1e-3, short_links = 1e-5;
  for (const double shrinkage : {1e-8, 1e-10, 1e-12, 1e-14, 0.0}) {
    CAPTURE(shrinkage);
    const LaplaceSolution solution = lattice(shrinkage);
    CHECK(solution.iterations <= usual.iterations + 2);
    for (int k = 0; k < 100; ++k)
      CHECK(solution.group_potential[k] ==
            doctest::Approx(usual.group_potential[k]).epsilon(shrinkage > 0 ? short_links : truncation));
  }
}

TEST_CASE("disk within a cell, shrunk: potential rises by Q ln(r1/r2) / (2 pi eps)") {
  // The distant field depends only on the charge: shrinking the disk from r1 to r2 raises its potential by Q ln(r1/r2)
  // / 2 pi. The four neighbours differ in their distance to the walls by the order (h/L)^2 = (1/64)^2 = 2.4e-4.
  double phi[2];
  const double radius[2] = {0.3, 1e-5};
  for (const int k : {0, 1}) {
    LaplaceProblem problem{.permittivity = 1};
    problem.size = {64, 64};
    problem.sides[left] = {Side::Kind::electrode, 0, {}};
    problem.bodies = {{Disk{{40.5, 30.5}, radius[k]}, 0}};
    problem.groups = {{true, 1, 0}};
    CutCellSolver solver(options(64));
    phi[k] = solver.solve(problem).group_potential[0];
  }
  CHECK(phi[1] - phi[0] == doctest::Approx(std::log(radius[0] / radius[1]) / (2 * pi)).epsilon(2.4e-4));
}

TEST_CASE("solution history: saves iterations; forget() restores the cold start") {
  LaplaceProblem problem = random_disks(12, 128, 6, 1);
  CutCellSolver solver(options(128));
  const LaplaceSolution first = solver.solve(problem);
  LaplaceProblem moved = problem;
  for (std::size_t k = 1; k < moved.bodies.size(); ++k)
    std::get<Disk>(moved.bodies[k].shape).centre += Vec2{0.02, 0.01};
  const LaplaceSolution warm = solver.solve(moved);
  solver.forget();
  const LaplaceSolution cold = solver.solve(moved);
  CutCellSolver fresh(options(128));
  const LaplaceSolution again = fresh.solve(moved);
  CHECK(warm.iterations < cold.iterations);
  for (std::size_t g = 0; g < cold.group_potential.size(); ++g) {
    CHECK(warm.group_potential[g] == doctest::Approx(cold.group_potential[g]).epsilon(1e-8));
    CHECK(cold.group_potential[g] == again.group_potential[g]);
  }
  CHECK(first.unknowns > 0);
}

namespace {

/// Problem after group `from` merges with group 1.
LaplaceProblem with_merged(LaplaceProblem problem, int from) {
  problem.groups[1].charge += problem.groups[from].charge;
  problem.groups.erase(problem.groups.begin() + from);
  for (Body& body : problem.bodies) {
    if (body.group == from) body.group = 1;
    if (body.group > from) --body.group;
  }
  return problem;
}

}  // namespace

TEST_CASE("CutCellSolver::follow: a coarse solver saves iterations after a merge") {
  const LaplaceProblem before = random_disks(30, 256, 10, 1), after = with_merged(before, 2);
  CutCellSolver coarse(options(64, 1e-4)), following(options(256, 1e-5)), alone(options(256, 1e-5));
  following.follow(coarse);
  for (const LaplaceProblem* problem : {&before, &after}) {
    coarse.solve(*problem);
    const LaplaceSolution with = following.solve(*problem), without = alone.solve(*problem);
    if (problem == &before) {
      CHECK(with.iterations == without.iterations);
      continue;
    }
    CHECK(with.iterations < without.iterations);
    // Each solution has an error of its tolerance in the energy norm.
    double largest = 0;
    for (const double potential : without.group_potential) largest = std::max(largest, std::abs(potential));
    for (std::size_t g = 0; g < without.group_potential.size(); ++g)
      CHECK(std::abs(with.group_potential[g] - without.group_potential[g]) < 2e-5 * largest);
  }
}

TEST_CASE("add_change: bilinear, odd at electrode sides, even at insulating sides") {
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {32, 32};
  problem.sides[left] = {Side::Kind::electrode, 0, {}};
  problem.bodies = {{Disk{{20, 16}, 5}, 0}};
  problem.groups = {{true, 1, 0}};
  Level level(problem, 32, 32);
  LevelBuilder().build(problem, LinkFormula::log_fitted, level);
  CutCellOperator op;
  op.build(problem, level);
  // The change is odd about the electrode on the left. Bilinear interpolation is exact except within half a coarse cell
  // of the side on the right.
  Potentials none{8, 8, std::vector<double>(64), {1}}, change = none;
  for (int j = 0; j < 8; ++j)
    for (int i = 0; i < 8; ++i) change.cell[8 * j + i] = 4 * (i + 0.5);
  change.body[0] = 21;
  const double scale = 2;
  std::vector<double> x(op.size(), 3);
  add_change(none, change, problem, scale, op, x);
  for (int j = 0; j < 32; ++j)
    for (int i = 0; i < 32; ++i) {
      const double added = x[level.layout(i, j)] - 3, whole = i < 30 ? i + 0.5 : 30;
      CHECK(added == doctest::Approx(level.diagonal[level.layout(i, j)] > 0 ? whole / scale : 0).epsilon(1e-12));
    }
  CHECK(x[op.cells()] == doctest::Approx(3 + 20 / scale).epsilon(1e-12));
}

TEST_CASE("box that is not a whole number of cells: refused") {
  LaplaceProblem problem = random_disks(1, 64, 5, 1);
  problem.size.y = 50.3;
  CutCellSolver solver(options(64));
  CHECK_THROWS_AS(solver.solve(problem), InputError);
}

TEST_CASE("conductors covering all cells: charges and C phi = q are met") {
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {8, 8};
  problem.sides[bottom] = {Side::Kind::electrode, 1, {}};
  for (int k = 0; k < 64; ++k) {
    problem.bodies.push_back({Disk{{k % 8 + 0.5, k / 8 + 0.5 + 0.01 * (k % 3)}, 0.4}, k});
    problem.groups.push_back({true, 0.1 * (k % 5) - 0.15, 0});
  }
  CutCellSolver solver(options(8));
  const LaplaceSolution solution = solver.solve(problem);
  CHECK(solution.unknowns == 64);
  for (int k = 0; k < 64; ++k)  // Rounding of a few links with conductances of some tens at a few volts.
    CHECK(solution.body_charge[k] == doctest::Approx(problem.groups[k].charge).epsilon(1e-12));
  // The capacitance matrix, computed with all potentials given and thus no unknowns, obeys C phi = q relative to the
  // electrode.
  const std::vector<double> capacitance = capacitance_matrix(solver, problem);
  for (int k = 0; k < 64; ++k) {
    double charge = 0;
    for (int l = 0; l < 64; ++l) charge += capacitance[64 * k + l] * (solution.group_potential[l] - 1);
    CHECK(charge == doctest::Approx(problem.groups[k].charge).epsilon(1e-8));
  }
}

TEST_CASE("charges beyond double precision: refused with an error message") {
  LaplaceProblem problem = random_disks(3, 64, 6, 4);
  problem.permittivity = 1e-12;
  for (Group& group : problem.groups) group.charge = group.floating ? 1e300 : 0;
  CutCellSolver solver(options(64));
  CHECK(message_of([&] { solver.solve(problem); }).find("too large for double precision") != std::string::npos);
}

TEST_CASE("LaplaceSolution::work: equals a manual count of residual evaluations") {
  // Two grids of 16 x 16 and 8 x 8 cells permit a manual count. A V-cycle costs 3: red cells from zero (no stencil),
  // black cells 1/2, residual of red cells 1/2, its restriction 1/2, interpolation to red cells 1/2, black cells 1/2,
  // red cells 1/2. The coarser grid is solved directly. Each iteration adds one operator application. The first
  // residual costs 1, and interpolating the initial guess to the finest grid costs 1. Four sweeps over the cells with
  // links follow the guess. The last cycle is skipped if its correction is predicted to be below the tolerance.
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {16, 16};
  problem.sides[left] = {Side::Kind::electrode, 0, {}};
  problem.bodies = {{Disk{{9, 8}, 3}, 0}};
  problem.groups = {{true, 1, 0}};
  CutCellSolver solver(options(16));
  Level level(problem, 16, 16);
  LevelBuilder().build(problem, LinkFormula::log_fitted, level);
  std::set<std::ptrdiff_t> with_links;
  for (const FluidLink& link : level.links) with_links.insert(link.cell);
  const double edge_sweeps = 4.0 * static_cast<double>(with_links.size()) / (16 * 16);
  const LaplaceSolution cold = solver.solve(problem);
  CHECK(cold.iterations > 1);
  const double with_last_cycle = 1 + edge_sweeps + 1 + 3 + cold.iterations * (1 + 3), last_cycle = 3;
  CHECK(std::min(std::abs(cold.work - with_last_cycle), std::abs(cold.work - with_last_cycle + last_cycle)) < 1e-12);
  // A repeated solve: the history contains the solution, and one operator application confirms it.
  const LaplaceSolution warm = solver.solve(problem);
  CHECK(warm.iterations == 0);
  CHECK(warm.work == doctest::Approx(1 + edge_sweeps + 1 + 3).epsilon(1e-12));
}

// Number of requests for a side's potential by the worker thread, which discretizes the coarse grids. The caller's
// solve fails when PETSc creates the preconditioner of the options; this creation waits for the first request.
std::atomic<int> worker_requests = 0;

PetscErrorCode make_while_worker_runs(PC) {
  for (int ms = 0; ms < 30000 && worker_requests == 0; ++ms) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  return 0;
}

TEST_CASE("failed solve: no worker thread uses its problem afterwards") {
  parallel::start_petsc();
  CutCellOptions two_threads = options(256);
  two_threads.threads = 2;
  std::atomic<bool> over = false;
  std::atomic<int> afterwards = 0;
  LaplaceProblem problem = two_disks(256, {128.3, 127.8}, {1, 0}, 16, 40);
  const auto exact = problem.sides[0].profile;
  for (Side& side : problem.sides)
    side.profile = [&, exact, caller = std::this_thread::get_id()](Vec2 p) {
      if (std::this_thread::get_id() != caller) {
        ++worker_requests;
        // The worker is still active when the caller fails.
        std::this_thread::sleep_for(std::chrono::microseconds(200));
      }
      if (over) ++afterwards;
      return exact(p);
    };
  parallel::check_petsc(PCRegister("once_helper_is_at_work", make_while_worker_runs));
  parallel::check_petsc(PetscOptionsSetValue(nullptr, "-field_pc_type", "once_helper_is_at_work"));
  CutCellSolver solver(two_threads);
  const std::string sentence = message_of([&] { solver.solve(problem); });
  over = true;
  parallel::check_petsc(PetscOptionsClearValue(nullptr, "-field_pc_type"));
  CHECK_NE(sentence.find("-field_pc_type once_helper_is_at_work needs a matrix"), std::string::npos);
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  CHECK(worker_requests > 0);
  CHECK(afterwards == 0);
}

}  // namespace cutcell_test
