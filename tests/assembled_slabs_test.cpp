// Tests of the multigrid whose rows are divided among processes: `mpirun -n 2 assembled_tests`. One process has all
// rows.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "solvers/laplace/cutcell/grid_sizes.hpp"
#include "solvers/laplace/cutcell/matrix_free.hpp"
#include "solvers/laplace/cutcell/results.hpp"
#include "solvers/laplace/cutcell/solver.hpp"
#include "solvers/parallel/petsc.hpp"
#include "tests/random_placement.hpp"

namespace assembled_slabs_test {

using namespace lichtenberg;
using namespace lichtenberg::laplace;

namespace {

constexpr double tolerance = 1e-10;
constexpr int cells = 768;

/// Potentials have the tolerance in the energy norm relative to the solution's norm. In a box of a few radii with a few
/// groups the largest group potential is of the order of this norm. A factor of 100 covers the constants.
constexpr double agreement = 100 * tolerance;

/// Disks of a radius between 0.25 and 4 times `radius` at random positions, with gaps of 1 % of a cell and more. The
/// last two have one potential, and so have the first two, at the bottom and the top of the box.
/// `bar`: with a grounded bar from bottom to top.
LaplaceProblem random_disks(int count, double radius, bool bar = false) {
  random_placement::Random random(3);
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {96, 64};
  problem.bodies = {{Disk{{20, 5}, 3}, 0}, {Disk{{20, 59}, 3}, 0}};
  problem.groups = {{true, 0.5, 0}};
  if (bar) {
    problem.bodies.push_back({Bar{{60, 2}, {62, 62}, 0.3}, 1});
    problem.groups.push_back({false, 0, 2});
  }
  while (static_cast<int>(problem.bodies.size()) < count) {
    const double r = radius * std::pow(2, random(-2, 2));
    const Disk disk{{random(r + 1, 95 - r), random(r + 1, 63 - r)}, r};
    random_placement::add_if_free(problem, disk, 0.01 * problem.size.x / cells, random);
  }
  problem.bodies.back().group = static_cast<int>(problem.groups.size()) - 2;
  problem.groups.pop_back();
  return problem;
}

/// Returns a bound of the rounding errors of the groups' charges. CutCellOperator::balance() computes a charge as the
/// difference of two sums over the n links of a group, of conductance times potential. A sum has an error of at most n
/// roundings of the sum of all magnitudes (Higham 2002, section 4.2).
std::vector<double> charge_roundings(const LaplaceProblem& problem, const Level& level, double largest_potential) {
  std::vector<double> conductance(problem.groups.size(), 0.0), links(problem.groups.size(), 0.0);
  const auto add = [&](int group, double c) { conductance[group] += c, ++links[group]; };
  for (const FluidLink& link : level.links) add(problem.bodies[link.body].group, link.conductance);
  for (const PairLink& pair : level.pairs)
    for (const int body : {pair.body_a, pair.body_b}) add(problem.bodies[body].group, pair.conductance);
  for (const SideLink& link : level.side_links)
    if (link.body >= 0) add(problem.bodies[link.body].group, link.conductance);
  for (const Coupling& c : problem.couplings)
    for (const int group : {c.a, c.b}) add(group, c.capacitance);
  for (std::size_t g = 0; g < links.size(); ++g) conductance[g] *= 2 * links[g] * 0x1p-53 * largest_potential;
  return conductance;
}

/// Solves the problem on the whole grid in each process. Also sets the potentials of the fluid cells, by row, and the
/// bounds of the rounding errors of charges.
LaplaceSolution solve_whole(const LaplaceProblem& problem, std::vector<double>& field,
                            std::vector<double>& charge_rounding) {
  const GridSize size = finest_grid(problem, cells);
  Level level(problem, size.nx, size.ny);
  CutCellOperator op;
  MatrixFreeSystem system(LinkFormula::log_fitted, tolerance, parallel::Team::single());
  system.build(problem, level, op);
  system.finish();
  std::vector<double> b(op.size()), x(op.size(), 0.0);
  op.right_hand_side(problem, b.data());
  std::vector<double> residual = b;
  LaplaceSolution solution;
  system.solve(b, x, residual, {tolerance, 0, 0, 0}, solution);
  op.balance(problem, 1, b.data(), x.data());
  for (std::size_t g = 0; g < problem.groups.size(); ++g)
    solution.group_potential.push_back(problem.groups[g].floating ? x[op.cells() + g] : problem.groups[g].potential);
  evaluate(problem, level, x.data(), 1, solution);
  solution.unknowns = level.fluid_cells;
  for (const Group& group : problem.groups) solution.unknowns += group.floating;
  field.clear();
  for (int j = 0; j < size.ny; ++j)
    for (int i = 0; i < size.nx; ++i) field.push_back(x[level.layout(i, j)]);
  double largest = 0;
  for (const double potential : x) largest = std::max(largest, std::abs(potential));
  charge_rounding = charge_roundings(problem, level, largest);
  return solution;
}

double mean_potential(const LaplaceProblem& problem, const LaplaceSolution& solution) {
  double sum = 0;
  for (const Body& body : problem.bodies) sum += solution.group_potential[body.group];
  return problem.has_ground() ? 0.0 : sum / static_cast<double>(problem.bodies.size());
}

template <class Value, class Size>
void check_close(const std::vector<Value>& a, const std::vector<Value>& b, double bound, const Size& size) {
  REQUIRE(a.size() == b.size());
  double largest = 0, difference = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    largest = std::max(largest, size(a[k]));
    difference = std::max(difference, size(a[k] - b[k]));
  }
  CHECK(difference <= bound * largest);
}

/// Checks that the solution is that of the whole grid, and that charges are those given.
void check_solution(const LaplaceProblem& problem, const LaplaceSolution& solution, const Field& field) {
  std::vector<double> whole_field, charge_rounding;
  LaplaceSolution whole = solve_whole(problem, whole_field, charge_rounding);
  CHECK(solution.unknowns == whole.unknowns);
  const double shift = mean_potential(problem, whole);
  for (double& phi : whole.group_potential) phi -= shift;
  const auto size = [](double value) { return std::abs(value); };
  check_close(whole.group_potential, solution.group_potential, agreement, size);
  // The charge of a body is a sum over some hundred links.
  check_close(whole.body_charge, solution.body_charge, 10 * agreement, size);
  // Through the shortest link, 100 cells, squared.
  check_close(whole.body_force, solution.body_force, 1e4 * agreement, [](Vec2 f) { return norm(f); });
  CHECK(solution.energy == doctest::Approx(whole.energy).epsilon(agreement));
  for (int side = 0; side < 4; ++side)
    CHECK(std::abs(solution.side_charge[side] - whole.side_charge[side]) <= agreement * std::abs(whole.energy));
  std::vector<double> charge(problem.groups.size(), 0.0);
  for (std::size_t k = 0; k < problem.bodies.size(); ++k) charge[problem.bodies[k].group] += solution.body_charge[k];
  for (const Coupling& c : problem.couplings) {
    const double flow = c.capacitance * (solution.group_potential[c.a] - solution.group_potential[c.b]);
    charge[c.a] += flow;
    charge[c.b] -= flow;
  }
  for (std::size_t g = 0; g < problem.groups.size(); ++g)
    if (problem.groups[g].floating) CHECK(std::abs(charge[g] - problem.groups[g].charge) <= charge_rounding[g]);
  if (parallel::process_rank() > 0) return;
  REQUIRE(field.value.size() == whole_field.size());
  double difference = 0;
  for (std::size_t k = 0; k < field.value.size(); ++k)
    if (field.body[k] < 0) difference = std::max(difference, std::abs(field.value[k] - (whole_field[k] - shift)));
  CHECK(difference <= agreement * std::abs(*std::ranges::max_element(whole.group_potential)));
}

struct Case {
  std::string name;
  LaplaceProblem problem;
};

std::vector<Case> cases() {
  std::vector<Case> all;
  LaplaceProblem problem = random_disks(40, 1.5);
  problem.sides[left] = {Side::Kind::electrode, 1, {}};
  all.push_back({"electrode on the left", problem});
  problem.sides[bottom] = problem.sides[top] = {Side::Kind::electrode, -2, {}};
  all.push_back({"electrodes on three sides", problem});
  problem.couplings = {{0, 3, 100}, {3, 6, 0.5}, {6, 9, 1e-6}};
  all.push_back({"couplings", problem});
  all.push_back({"grounded bar through all slabs", random_disks(30, 1.5, true)});
  problem = random_disks(400, 0.35);
  problem.sides[right] = {Side::Kind::electrode, 1, {}};
  all.push_back({"small disks", problem});
  problem = random_disks(40, 1.5);
  for (std::size_t g = 1; g < problem.groups.size(); ++g) problem.groups[0].charge -= problem.groups[g].charge;
  problem.groups[0].charge -= 0.5;
  all.push_back({"no ground", problem});
  return all;
}

}  // namespace

TEST_CASE("slabs: rows of all grids are divided without gaps, at even rows") {
  for (const int processes : {1, 2, 3, 5, 7}) {
    CAPTURE(processes);
    std::vector<std::vector<Layout>> of;
    for (int k = 0; k < processes; ++k) of.push_back(grid_layouts(1024, 768, k, processes));
    for (std::size_t l = 0; l < of[0].size(); ++l) {
      CAPTURE(l);
      int next = 0;
      for (int k = 0; k < processes; ++k) {
        const Layout& at = of[k][l];
        CHECK(at.is_divided() == of[0][l].is_divided());
        if (!at.is_divided()) continue;
        CHECK(at.own.begin == next);
        CHECK(at.own.count() > Layout::ghosts);
        next = at.own.end;
        if (l > 0) CHECK(2 * at.own.begin == of[k][l - 1].own.begin);
        if (!of[k][l + 1].is_divided()) CHECK(at.own.begin % 2 == 0);
      }
      if (of[0][l].is_divided()) CHECK(next == of[0][l].ny);
    }
    CHECK(of[0][0].is_divided() == (processes > 1));
    CHECK(!of[0].back().is_divided());
  }
}

/// One V-cycle on the rows that `at` has, for a residual that depends on the cell only. Returns the result in own rows
/// and, at the end, of the groups.
std::vector<double> cycle_on(const LaplaceProblem& problem, const Layout& at) {
  Level level(problem, at);
  LevelBuilder().build(problem, LinkFormula::log_fitted, level);
  Multigrid multigrid(LinkFormula::log_fitted);
  multigrid.prepare(problem, at);
  multigrid.build_coarse(problem, level);
  multigrid.build_finest(problem, level);
  multigrid.finish();
  std::vector<double> r(at.size() + problem.groups.size(), 0.0), z(r.size()), result;
  for (int j = at.own.begin; j < at.own.end; ++j)
    for (int i = 0; i < at.nx; ++i)
      if (level.diagonal[at(i, j)] > 0) r[at(i, j)] = std::sin(3.0 * i * j + i) + 0.1;
  for (std::size_t g = 0; g < problem.groups.size(); ++g)
    if (problem.groups[g].floating) r[at.size() + g] = std::cos(5.0 * static_cast<double>(g));
  multigrid.apply(r.data(), z.data());
  for (int j = at.own.begin; j < at.own.end; ++j)
    for (int i = 0; i < at.nx; ++i) result.push_back(z[at(i, j)]);
  result.insert(result.end(), z.begin() + at.size(), z.end());
  return result;
}

TEST_CASE("slabs: a V-cycle equals that on the whole grid to single precision") {
  parallel::start_petsc();
  for (const auto& [name, problem] : cases()) {
    if (!problem.has_ground()) continue;  // the level of potentials is arbitrary
    CAPTURE(name);
    const GridSize size = finest_grid(problem, cells);
    const Layout own = grid_layouts(size.nx, size.ny, parallel::process_rank(), parallel::process_count()).front();
    const std::vector<double> whole = cycle_on(problem, Layout(size.nx, size.ny)), part = cycle_on(problem, own);
    double largest = 0, difference = 0;
    const std::size_t first = static_cast<std::size_t>(own.own.begin) * own.nx, groups = problem.groups.size();
    for (std::size_t k = 0; k < part.size(); ++k) {
      const double expected = k < part.size() - groups ? whole[first + k] : whole[whole.size() - part.size() + k];
      largest = std::max(largest, std::abs(expected));
      difference = std::max(difference, std::abs(part[k] - expected));
    }
    // Sums of some thousand terms in another order, on five grids.
    CHECK(difference < 1e-5 * largest);
  }
}

TEST_CASE("slabs: solutions equal those on the whole grid, also after motion") {
  parallel::start_petsc();
  for (auto& [name, problem] : cases()) {
    CAPTURE(name);
    CutCellSolver solver({.cells = cells, .tolerance = tolerance, .threads = 1});
    for (int step = 0; step < 3; ++step) {
      CAPTURE(step);
      const LaplaceSolution solution = solver.solve(problem);
      check_solution(problem, solution, solver.field());
      for (Body& body : problem.bodies)
        if (Disk* disk = std::get_if<Disk>(&body.shape)) disk->centre += Vec2{0.001, 0.03};
    }
  }
}

TEST_CASE("slabs: a solver follows one on a coarser grid") {
  parallel::start_petsc();
  LaplaceProblem problem = cases().front().problem;
  CutCellSolver solver({.cells = cells, .tolerance = 1e-6, .threads = 1});
  CutCellSolver coarser({.cells = cells / 2, .tolerance = 1e-6, .threads = 1});
  CutCellSolver cold({.cells = cells, .tolerance = 1e-6, .threads = 1});
  solver.follow(coarser);
  for (int step = 0; step < 3; ++step) {
    coarser.solve(problem);
    const LaplaceSolution followed = solver.solve(problem);
    cold.forget();
    const LaplaceSolution anew = cold.solve(problem);
    for (std::size_t g = 0; g < problem.groups.size(); ++g)
      CHECK(std::abs(followed.group_potential[g] - anew.group_potential[g]) < 1e-4);
    if (step > 0) CHECK(followed.iterations < anew.iterations);
    for (Body& body : problem.bodies) std::get<Disk>(body.shape).centre += Vec2{0.001, 0.003};
  }
}

}  // namespace assembled_slabs_test
