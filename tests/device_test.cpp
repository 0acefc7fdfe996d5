// Tests of the device's algorithms, executed by the CPU item by item, against the CPU's solver.

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "solvers/error.hpp"
#include "solvers/laplace/cutcell/device/device.hpp"
#include "solvers/laplace/cutcell/device/grids.hpp"
#include "solvers/laplace/cutcell/device/multigrid.hpp"
#include "solvers/laplace/cutcell/level_builder.hpp"
#include "solvers/laplace/cutcell/multigrid.hpp"
#include "solvers/laplace/cutcell/operator.hpp"
#include "solvers/parallel/host_executor.hpp"
#include "tests/device_scenes.hpp"

namespace device_test {

using namespace lichtenberg;
using namespace lichtenberg::laplace;
using namespace lichtenberg::laplace::device_scenes;

namespace {

/// Problem with some of the groups merged: a few large groups with unordered numbers.
LaplaceProblem merged(LaplaceProblem problem) {
  const int groups = static_cast<int>(problem.groups.size());
  for (Body& body : problem.bodies)
    if (body.group > 4) body.group = 1 + body.group % 4;
  problem.groups.resize(std::min(groups, 5));
  return problem;
}

/// Problem of a dish with a bar on the ground and a few disks, one of them far smaller than a cell.
LaplaceProblem dish() {
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {64, 64};
  problem.bodies = {{Ring{{32, 32}, 30}, 0}, {Bar{{20, 25}, {40, 28}, 0.7}, 1}, {Disk{{30, 40}, 6}, 2},
                    {Disk{{44, 40}, 5}, 3},  {Disk{{37.4, 40.2}, 0.6}, 4},      {Disk{{20.1, 18.2}, 0.3}, 2}};
  problem.groups = {{false, 0, 0.0}, {false, 0, 1.0}, {true, 0.5, 0}, {true, -0.7, 0}, {true, 0.2, 0}};
  return problem;
}

/// Problem of disks in their own cells, several disks in one cell, and touching neighbours, on a grid of one cell per
/// metre.
LaplaceProblem shared_cells() {
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {32, 32};
  problem.sides[left].kind = problem.sides[bottom].kind = Side::Kind::electrode;
  problem.sides[left].profile = [](Vec2 p) { return 0.1 * p.y; };
  const std::vector<Disk> disks{{{10.2, 10.3}, 0.15}, {{10.7, 10.8}, 0.2},   {{10.2, 10.8}, 0.1}, {{16.5, 16.5}, 3},
                                {{19.6, 16.4}, 0.05}, {{19.71, 16.4}, 0.04}, {{24.9, 20.2}, 2.2}, {{25.1, 24.7}, 2.2},
                                {{0.4, 20.3}, 0.3},   {{5.3, 0.6}, 1.1}};
  for (const Disk& disk : disks) {
    problem.bodies.push_back({disk, static_cast<int>(problem.groups.size())});
    problem.groups.push_back({true, 0.1 * static_cast<double>(problem.groups.size()) - 0.3, 0});
  }
  problem.bodies[1].group = 6;  // Larger than the group of the disk whose cell it shares.
  problem.groups[1] = {false, 0, 0.2};
  return problem;
}

/// Problem of floating and grounded bars, shorter or narrower than the cells of coarse grids.
LaplaceProblem short_bars() {
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {64, 64};
  problem.sides[left].kind = problem.sides[right].kind = Side::Kind::electrode;
  problem.sides[right].potential = 1;
  problem.bodies = {{Bar{{20, 25}, {20.5, 26}, 3}, 0},
                    {Bar{{40, 28}, {42, 28}, 0.3}, 1},
                    {Bar{{12, 50}, {13, 51}, 1}, 2},
                    {Bar{{50, 50}, {50, 50.4}, 9}, 3}};
  problem.groups = {{true, 0.5, 0}, {true, -0.7, 0}, {false, 0, 0.5}, {true, 0.2, 0}};
  return problem;
}

struct Case {
  const char* name;
  LaplaceProblem problem{.permittivity = 1};
  int cells;  // Number of cells along the longer side.
};

std::vector<Case> cases() {
  return {{"disks", random_disks(25, 0.6), 192},
          {"narrow gaps", random_disks(35, 0.01), 96},
          {"groups", merged(random_disks(35, 0.01)), 96},
          {"dish", dish(), 128},
          {"short bars", short_bars(), 128},
          {"shared cells", shared_cells(), 32},
          {"insulated", insulated(), 96},
          {"one grid", narrow_box(), 16}};
}

struct Discretized {
  Discretized(const LaplaceProblem& problem, int nx, int ny, LinkFormula formula)
      : on_device(run), grid(run, nx, ny, problem.size.x / nx, formula, true) {
    on_device.upload(problem, nx, ny);
    do {  // Repeats until the capacity suffices.
      grid.enlarge(on_device.view(), required);
      grid.reserve(on_device.view(), {.has_medium = false, .number = number.data(), .required = required.data()});
      grid.outline(on_device.view(), nullptr);
      grid.build(on_device.view());
    } while (!grid.fits(required));
  }
  int number_of(device::Items::Kind kind) const { return number[kind]; }
  parallel::HostExecutor run;
  device::Numbers number{}, required{};
  device::DeviceProblem<parallel::HostExecutor> on_device;
  device::DeviceGrid<parallel::HostExecutor> grid;
};

/// Centre of a cell, from the inverse of the numbering of `Layout`.
Vec2 centre_of(std::ptrdiff_t slot, const Layout& at) {
  const int colour = static_cast<int>(slot / at.colour_size());
  const std::ptrdiff_t offset = slot % at.colour_size() - Layout::pad;
  const int j = static_cast<int>(offset / at.stride) - 1, n = static_cast<int>(offset % at.stride);
  return {2 * n + Layout::parity(colour, j) + 0.5, j + 0.5};
}

/// Relative difference permitted between a link at a disk and the CPU's, which computes several links at once by its
/// own series. Both have r^2 - R^2 with the rounding of R^2, divided by some cells times R, or by 1e-4 for a short cut.
/// Equal functions of equal arguments compute all other links.
double rounding_of(const FluidLink& link, const LaplaceProblem& problem, const Level& level) {
  const Disk* disk = std::get_if<Disk>(&problem.bodies[link.body].shape);
  if (!disk) return 0;
  const double h = problem.size.x / level.layout.nx, radius = disk->radius / h;
  const double cut = norm(centre_of(link.cell, level.layout) - disk->centre / h) - radius;
  return 1e-15 * (1 + radius / std::max(cut, smallest_cut));
}

/// Permitted differences of the sums of links of each cell, followed by those of each group.
std::vector<double> rounding_of_sums(const LaplaceProblem& problem, const Level& level) {
  const std::size_t cells = level.layout.size();
  std::vector<double> sums(cells + problem.groups.size());
  for (const FluidLink& link : level.links) {
    const double rounding = rounding_of(link, problem, level) * link.conductance;
    sums[link.cell] += rounding;
    sums[cells + problem.bodies[link.body].group] += rounding;
  }
  return sums;
}

/// Body index; -1 for fluid.
int body_at(CellOwner owner) { return owner.is_fluid() ? -1 : owner.body(); }

}  // namespace

TEST_CASE("device grid: cell owners and links equal the CPU solver's") {
  for (const Case& c : cases())
    for (const LinkFormula formula : {LinkFormula::log_fitted, LinkFormula::plain}) {
      CAPTURE(std::string(c.name));
      const int nx = c.cells, ny = static_cast<int>(std::lround(nx * c.problem.size.y / c.problem.size.x));
      Level level(c.problem, nx, ny);
      LevelBuilder().build(c.problem, formula, level);
      Discretized device(c.problem, nx, ny, formula);
      const device::GridView& view = device.grid.view();
      const Layout& at = level.layout;
      int different = 0;
      for (std::ptrdiff_t slot = 0; slot < at.size(); ++slot)
        different += body_at(view.cells.owner[slot]) != body_at(level.owner[slot]);
      CHECK(different == 0);
      CHECK(device.grid.fluid_cells(device.number) == level.fluid_cells);

      REQUIRE(device.number_of(device::Items::links) == static_cast<int>(level.links.size()));
      std::map<std::pair<std::ptrdiff_t, int>, std::vector<FluidLink>> expected;
      for (const FluidLink& link : level.links) expected[{link.cell, link.body}].push_back(link);
      for (int m = 0; m < device.number_of(device::Items::links); ++m) {
        auto& links = expected[{view.links.slot[m], view.links.end[m].body()}];
        const auto found = std::find_if(links.begin(), links.end(), [&](const FluidLink& link) {
          const double share = rounding_of(link, c.problem, level);
          // Gradients: rounding of a few terms that may cancel, each at most the conductance squared.
          const double term_rounding = 1e-14 * (1 + link.conductance * link.conductance);
          return std::abs(link.conductance - view.links.conductance[m]) <= share * link.conductance &&
                 norm(link.gradient - view.links.gradient[m]) <= term_rounding + 2 * share * norm(link.gradient);
        });
        REQUIRE(found != links.end());
        CHECK(view.links.group[m] == c.problem.bodies[view.links.end[m].body()].group);
        links.erase(found);
      }
      const std::vector<double> rounding = rounding_of_sums(c.problem, level);
      for (int k = 0; k < device.number_of(device::Items::boundary); ++k) {
        const double exact = level.diagonal[view.boundary.slot[k]];
        // The CPU adds c - 1 to 4 for each face: rounding of at most four such sums of terms not larger than the sum +
        // 4.
        REQUIRE(std::abs(view.boundary.diagonal[k] - exact) <= 16 * 1.1e-16 * exact + rounding[view.boundary.slot[k]]);
      }
      for (std::ptrdiff_t slot = 0; slot < at.size(); ++slot) {
        const double exact = level.diagonal[slot] > 0 ? 1 / level.diagonal[slot] : 0;
        if (std::abs(view.cells.inverse_diagonal[slot] - exact) > 2e-7 * exact) ++different;  // Two roundings to float.
      }
      CHECK(different == 0);

      // Each pair is a gap conductance of both bodies, and each side link of a body is one.
      std::size_t side_links = 0;
      for (const SideLink& link : level.side_links) side_links += link.body >= 0;
      CHECK(static_cast<std::size_t>(device.number_of(device::Items::direct_links)) ==
            2 * level.pairs.size() + side_links);
      double sum = 0, device_sum = 0;
      for (const PairLink& pair : level.pairs) sum += 2 * pair.conductance;
      for (const SideLink& link : level.side_links) sum += link.body >= 0 ? link.conductance : 0;
      for (int m = 0; m < device.number_of(device::Items::direct_links); ++m)
        device_sum += view.direct.link[m].conductance;
      CHECK(device_sum == doctest::Approx(sum).epsilon(1e-13));  // Rounding of a sum of about 100 terms.
    }
}

TEST_CASE("test cases of the device: contain gaps, shared cells and large groups") {
  bool pairs = false, shared_cell = false, cross = false, body_at_side = false, large_group = false;
  for (const Case& c : cases()) {
    const int nx = c.cells, ny = static_cast<int>(std::lround(nx * c.problem.size.y / c.problem.size.x));
    Level level(c.problem, nx, ny);
    LevelBuilder().build(c.problem, LinkFormula::log_fitted, level);
    Discretized device(c.problem, nx, ny, LinkFormula::log_fitted);
    pairs = pairs || !level.pairs.empty();
    cross = cross || !level.cross_gradients.empty();
    for (const SideLink& link : level.side_links) body_at_side = body_at_side || link.body >= 0;
    for (std::size_t b = 0; b < c.problem.bodies.size(); ++b)
      shared_cell = shared_cell || device.grid.view().bodies.cell_owner[b] >= 0;
    for (std::size_t g = 0; g < c.problem.groups.size(); ++g)
      large_group = large_group || device.grid.view().pieces.start[g + 1] - device.grid.view().pieces.start[g] > 1;
  }
  CHECK(pairs);
  CHECK(shared_cell);
  CHECK(cross);
  CHECK(body_at_side);
  CHECK(large_group);
}

TEST_CASE("device: operator and right-hand side equal the CPU solver's") {
  for (const Case& c : cases()) {
    CAPTURE(std::string(c.name));
    const int nx = c.cells, ny = static_cast<int>(std::lround(nx * c.problem.size.y / c.problem.size.x));
    Level level(c.problem, nx, ny);
    LevelBuilder().build(c.problem, LinkFormula::log_fitted, level);
    CutCellOperator op;
    op.build(c.problem, level);
    Discretized device(c.problem, nx, ny, LinkFormula::log_fitted);
    random_placement::Random random(11);
    std::vector<double> x(op.size(), 0.0), y(op.size()), device_y(op.size(), -7.0), b(op.size()), device_b(op.size());
    const std::size_t cells = level.layout.size();
    for (std::size_t k = 0; k < op.size(); ++k) x[k] = k >= cells || level.diagonal[k] > 0 ? random(-1, 1) : 0;
    for (std::size_t g = 0; g < c.problem.groups.size(); ++g)
      if (!c.problem.groups[g].floating) x[cells + g] = 0;
    op.apply(x.data(), y.data());
    device::apply_operator(device.run, device.on_device.view(), device.grid.view(), x.data(), device_y.data());
    op.right_hand_side(c.problem, b.data());
    device::right_hand_side(device.run, device.on_device.view(), device.grid.view(), device_b.data());
    const std::vector<double> link_rounding = rounding_of_sums(c.problem, level);
    for (std::size_t k = 0; k < op.size(); ++k) {
      // Rounding of sums of at most about 200 terms, each at most the diagonal; links times differences of at most 2.
      const double diagonal = k < cells ? level.diagonal[k] : device.grid.view().groups.diagonal[k - cells];
      const double rounding = 200 * 1.1e-16 * (1 + diagonal) + 2 * link_rounding[k];
      REQUIRE(std::abs(y[k] - device_y[k]) <= rounding);
      REQUIRE(std::abs(b[k] - device_b[k]) <= rounding);
    }
  }
}

namespace {

/// Problem of three bars above a half-disk. Their sides lie between cells of 8 m and of all smaller ones, except for
/// one end each that extends farther. On the coarsest grid, of cells 8 m wide, no two are neighbours.
LaplaceProblem bars(double farther) {
  LaplaceProblem problem = random_disks(0, 20);
  const double ends[3][4] = {{8, 32, 24, 32}, {40, 32, 56, 32}, {72, 48, 88, 48}};
  for (const auto& [x, y, to_x, to_y] : ends) {
    problem.bodies.push_back({Bar{{x, y}, {to_x + farther, to_y}, 16}, static_cast<int>(problem.groups.size())});
    problem.groups.push_back({true, 0.3, 0});
  }
  return problem;
}

std::size_t count_eliminated_cells(const LaplaceProblem& problem, int nx, int ny) {
  Level level(problem, nx, ny);
  LevelBuilder().build(problem, LinkFormula::log_fitted, level);
  return level.eliminated.cells.size();
}

/// Largest difference between the V-cycles of device and CPU for random residuals, relative to the largest potential.
double difference_of_cycles(const LaplaceProblem& problem, int nx, int ny) {
  Level level(problem, nx, ny);
  LevelBuilder().build(problem, LinkFormula::log_fitted, level);
  CutCellOperator op;
  op.build(problem, level);
  Multigrid multigrid(LinkFormula::log_fitted, parallel::Team::single(),
                      1);  // One sweep, because kernel launches on the device are expensive.
  multigrid.prepare(problem, level.layout);
  multigrid.build_coarse(problem, level);
  multigrid.build_finest(problem, level);
  multigrid.finish();
  parallel::HostExecutor run;
  device::DeviceProblem<parallel::HostExecutor> on_device(run);
  device::DeviceMultigrid<parallel::HostExecutor> device(run, problem, nx, ny, LinkFormula::log_fitted);
  on_device.upload(problem, nx, ny);
  device.build(problem, on_device.view());
  REQUIRE(device.levels() == multigrid.levels());
  REQUIRE(device.levels() > 2);
  random_placement::Random random(11);
  std::vector<double> r(op.size(), 0.0), z(op.size()), device_z(op.size(), -7.0);
  const std::size_t cells = level.layout.size();
  for (std::size_t k = 0; k < op.size(); ++k) r[k] = k >= cells || level.diagonal[k] > 0 ? random(-1, 1) : 0;
  r[cells] = 0;  // The potential is given.
  multigrid.apply(r.data(), z.data());
  device.apply(r.data(), device_z.data());
  double worst = 0, largest = 0;
  for (std::size_t k = 0; k < op.size(); ++k) {
    worst = std::max(worst, std::abs(z[k] - device_z[k]));
    largest = std::max(largest, std::abs(z[k]));
  }
  return worst / largest;
}

// Single precision with a few hundred roundings of random sign.
constexpr double rounding_of_cycles = 20 * 6e-8;

}  // namespace

TEST_CASE("device V-cycle: equals the CPU's without eliminated cells") {
  const LaplaceProblem problem = bars(0);
  REQUIRE(count_eliminated_cells(problem, 96, 64) == 0);
  CHECK(difference_of_cycles(problem, 96, 64) < rounding_of_cycles);
}

TEST_CASE("device V-cycle: equals the CPU's with eliminated near-surface cells") {
  // The ends lie 0.1 cells from a column of centres: on the finest grid of 96 cells, or on 192 cells, the second of
  // three grids.
  const LaplaceProblem on_finest = bars(0.4), on_second = bars(0.2);
  REQUIRE(count_eliminated_cells(on_finest, 96, 64) == 3 * 16);
  CHECK(difference_of_cycles(on_finest, 96, 64) < rounding_of_cycles);
  REQUIRE(count_eliminated_cells(on_second, 384, 256) == 0);
  REQUIRE(count_eliminated_cells(on_second, 192, 128) == 3 * 32);
  CHECK(difference_of_cycles(on_second, 384, 256) < rounding_of_cycles);
}

TEST_CASE("device algorithms: potentials, charges and forces equal the CPU's") {
  for (Case& c : cases()) {
    CAPTURE(std::string(c.name));
    CutCellOptions options;
    options.cells = c.cells;
    options.tolerance = 1e-10;
    CutCellOptions to_rounding = options;
    to_rounding.tolerance = 1e-12;
    CutCellSolver alike(options), cpu(to_rounding);
    const std::unique_ptr<device::DeviceSolver> device = device::make_host_solver(options);
    for (int step = 0; step < 3; ++step) {  // The second and third solve use the history.
      const LaplaceSolution a = cpu.solve(c.problem), b = device->solve(c.problem);
      CHECK(b.unknowns == a.unknowns);
      // With gap conductances the two smoothers differ.
      const int iterations = alike.solve(c.problem).iterations;
      CHECK(b.iterations <= iterations + 2 + iterations / 3);
      double potential = 0, charge = 0, force = 0;
      for (const double v : a.group_potential) potential = std::max(potential, std::abs(v));
      for (const double q : a.body_charge) charge = std::max(charge, std::abs(q));
      for (const Vec2 f : a.body_force) force = std::max(force, norm(f));
      // The tolerance bounds the energy norm. Single values may have an error of the tolerance times sqrt(energy /
      // conductance), increased across a narrow gap by the root of its conductance: 1e-10 times about 100.
      const double accuracy = 1e-8;
      for (std::size_t g = 0; g < a.group_potential.size(); ++g)
        CHECK(std::abs(b.group_potential[g] - a.group_potential[g]) < accuracy * potential);
      for (std::size_t k = 0; k < a.body_charge.size(); ++k) {
        CHECK(std::abs(b.body_charge[k] - a.body_charge[k]) < accuracy * charge);
        CHECK(norm(b.body_force[k] - a.body_force[k]) < accuracy * force);
      }
      for (int side = 0; side < 4; ++side)
        CHECK(std::abs(b.side_charge[side] - a.side_charge[side]) < accuracy * charge);
      CHECK(b.energy == doctest::Approx(a.energy).epsilon(1e-9));
      const Field f = cpu.field(), g = device->field();
      CHECK(f.body == g.body);
      double worst = 0;
      for (std::size_t k = 0; k < f.value.size(); ++k) worst = std::max(worst, std::abs(f.value[k] - g.value[k]));
      CHECK(worst < accuracy * potential);
      for (Body& body : c.problem.bodies)
        if (auto* disk = std::get_if<Disk>(&body.shape)) disk->centre += Vec2{0.013, -0.007};
    }
  }
}

TEST_CASE("device algorithms: charges are exact to rounding at tolerance 1e-2") {
  for (const Case& c : cases()) {
    CAPTURE(std::string(c.name));
    CutCellOptions options;
    options.cells = c.cells;
    options.tolerance = 1e-2;
    const LaplaceSolution found = device::make_host_solver(options)->solve(c.problem);
    std::vector<double> charge(c.problem.groups.size(), 0.0);
    double sum = 0, largest = 0;
    for (std::size_t body = 0; body < c.problem.bodies.size(); ++body) {
      charge[c.problem.bodies[body].group] += found.body_charge[body];
      sum += found.body_charge[body];
      largest = std::max(largest, std::abs(found.body_charge[body]));
    }
    for (const double q : found.side_charge) sum += q;
    // Rounding of sums of some thousand fluxes that cancel, each at most a conductance of about 100 times the
    // potentials.
    for (std::size_t g = 0; g < charge.size(); ++g)
      if (c.problem.groups[g].floating) CHECK(std::abs(charge[g] - c.problem.groups[g].charge) < 1e-11 * largest);
    CHECK(std::abs(sum) < 1e-11 * largest);
  }
}

TEST_CASE("device solver: increases its capacity for more links, gaps or groups") {
  LaplaceProblem small = random_disks(30, 2), large = small;
  for (std::size_t body = 1; body < large.bodies.size(); ++body) {
    std::get<Disk>(small.bodies[body].shape).radius *= 0.3;   // A quarter of the links.
    std::get<Disk>(large.bodies[body].shape).radius += 0.98;  // Gaps of at least 0.04 cells.
  }
  CutCellOptions options;
  options.cells = 96;
  options.tolerance = 1e-10;
  const std::unique_ptr<device::DeviceSolver> device = device::make_host_solver(options);
  for (const LaplaceProblem& problem : {merged(small), small, merged(large), large, small}) {
    CutCellSolver cpu(options);
    const LaplaceSolution a = cpu.solve(problem), b = device->solve(problem);
    CHECK(b.unknowns == a.unknowns);
    REQUIRE(b.group_potential.size() == a.group_potential.size());
    double largest = 0;
    for (const double v : a.group_potential) largest = std::max(largest, std::abs(v));
    for (std::size_t g = 0; g < a.group_potential.size(); ++g)
      CHECK(std::abs(b.group_potential[g] - a.group_potential[g]) < 2e-8 * largest);  // As above.
  }
}

TEST_CASE("device memory too small: the solve fails and states the memory needed") {
  CutCellOptions options;
  options.cells = 192;
  parallel::HostExecutor::observed().memory = 1 << 20;
  CHECK_THROWS_WITH_AS(device::make_host_solver(options)->solve(random_disks(25, 0.6)),
                       "the field on 192 x 128 cells around 26 conductors needs 3 MiB of the device's memory, of which "
                       "1 MiB are free",
                       Failure);
  parallel::HostExecutor::observed() = {};
}

#ifndef LICHTENBERG_WITH_CUDA
TEST_CASE("device = \"cuda\" in a build without CUDA: refused with a message") {
  CutCellOptions options;
  options.device = CutCellOptions::Device::cuda;
  CHECK_THROWS_WITH_AS(CutCellSolver{options},
                       "device = \"cuda\": this program was built without CUDA; configure it with "
                       "-DLICHTENBERG_CUDA=ON",
                       InputError);
}
#endif

TEST_CASE("device iterations: one that is predicted to converge is the last") {
  device::Iterations iterations{};
  iterations.begin(1e-2, 100);
  iterations.criterion.energy_norm = 1;
  iterations.test_convergence(1e-2);  // From r'z the norm is 0.1, more than 0.01 sqrt(1 + 0.01).
  CHECK(iterations.go_on == 1);
  iterations.set_step(1);
  CHECK(iterations.go_on == 1);  // The first step makes no prediction.
  iterations.test_convergence(
      3e-4);  // The norm falls to 0.17 of it; the next step is predicted to halve this, to 0.0087.
  CHECK(iterations.go_on == 1);
  iterations.set_step(1);
  CHECK(iterations.go_on == 0);
  CHECK(iterations.reason == KSP_CONVERGED_RTOL);
  CHECK(iterations.done == 2);
  CHECK(iterations.norm[2] == doctest::Approx(0.5 * std::sqrt(3e-4)));
}

}  // namespace device_test
