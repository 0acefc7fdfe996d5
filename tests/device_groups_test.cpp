// Tests of nearly touching or coupled groups of conductors. The CPU executes the device's algorithms item by item.

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "solvers/laplace/cutcell/device/clusters.hpp"
#include "solvers/laplace/cutcell/device/coarsest.hpp"
#include "solvers/laplace/cutcell/device/device.hpp"
#include "solvers/laplace/cutcell/solver.hpp"
#include "solvers/parallel/host_executor.hpp"
#include "tests/device_scenes.hpp"

namespace device_groups_test {

using namespace lichtenberg;
using namespace lichtenberg::laplace;
using namespace lichtenberg::laplace::device_scenes;

namespace {

/// Returns the numbers of waits of the host for the device and of recorded kernels.
parallel::HostExecutor::Observed& observed() { return parallel::HostExecutor::observed(); }

/// Problem of disks of radius 8 m in a row with the given gap. The first disk has a charge, and the left side is an
/// electrode.
LaplaceProblem chain(int count, double gap) {
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {256, 128};
  problem.sides[left] = {Side::Kind::electrode, 1, {}};
  for (int k = 0; k < count; ++k) {
    problem.bodies.push_back({Disk{{20.2 + k * (16 + gap), 60.3}, 8}, k});
    problem.groups.push_back({true, k == 0 ? 1.0 : 0.0, 0});
  }
  return problem;
}

/// Largest difference between the potentials of device and CPU, relative to the largest potential.
double difference(const LaplaceSolution& device, const LaplaceSolution& cpu) {
  double worst = 0, largest = 0;
  for (std::size_t g = 0; g < cpu.group_potential.size(); ++g) {
    worst = std::max(worst, std::abs(device.group_potential[g] - cpu.group_potential[g]));
    largest = std::max(largest, std::abs(cpu.group_potential[g]));
  }
  return worst / largest;
}

}  // namespace

TEST_CASE("device algorithms, chain with gaps of 1e-6: iterations near the CPU's") {
  // Separate Jacobi relaxation of the twelve disks would not change their common mode.
  CutCellOptions options;
  options.cells = 256;
  options.tolerance = 1e-8;
  const LaplaceProblem separated = chain(12, 1), problem = chain(12, 1e-6);
  const std::unique_ptr<device::DeviceSolver> device = device::make_host_solver(options);
  device->solve(separated);  // The host takes no part in the set-up until there is such a link.
  const LaplaceSolution a = CutCellSolver(options).solve(problem), b = device->solve(problem);
  device->forget();
  const LaplaceSolution again = device->solve(problem);
  for (const LaplaceSolution& found : {b, again}) {
    CHECK(found.iterations <= a.iterations + 2 + a.iterations / 3);
    CHECK(difference(found, a) < 1000 * options.tolerance);  // As in cutcell_test.
  }
}

TEST_CASE("device algorithms, unresolved rows of disks: iterations near the CPU's") {
  // The row of disks of cutcell_grids_test, which coarse grids do not resolve, each alone or in one of six groups.
  // 200 disks form more than one cluster.
  CutCellOptions options;
  options.tolerance = 1e-8;
  struct Row {
    int disks, groups;
  };
  for (const Row row : {Row{60, 60}, Row{60, 6}, Row{200, 200}}) {
    CAPTURE(row.disks);
    CAPTURE(row.groups);
    options.cells = row.disks > 60 ? 384 : 128;
    LaplaceProblem problem{.permittivity = 1};
    problem.size = {static_cast<double>(options.cells), 128};
    problem.sides[left].kind = Side::Kind::electrode;
    for (int g = 0; g < row.groups; ++g) problem.groups.push_back({.floating = true, .charge = 1.0 + g % 3});
    for (int k = 0; k < row.disks; ++k)
      problem.bodies.push_back({Disk{{10 + (1.6 + 1e-5) * k, 64.3}, 0.8}, k % row.groups});
    const LaplaceSolution a = CutCellSolver(options).solve(problem);
    const LaplaceSolution b = device::make_host_solver(options)->solve(problem);
    CHECK(b.iterations <= a.iterations + 4 + a.iterations / 3);  // Coarse grids use one sweep instead of two.
    CHECK(difference(b, a) < 1000 * options.tolerance);
  }
}

TEST_CASE("device solver: host waits once per solve, 3 times with strong links") {
  CutCellOptions options;
  options.cells = 256;
  options.tolerance = 1e-8;
  LaplaceProblem coupled = chain(12, 8);
  coupled.couplings = {{0, 1, 1}};
  struct Scene {
    LaplaceProblem problem;
    int waits;
  };
  for (Scene scene : {Scene{chain(12, 8), 1}, Scene{chain(12, 1e-6), 3}, Scene{coupled, 3}}) {
    const auto solver = device::make_host_solver(options);
    for (int k = 0; k < 4; ++k) {  // Repeats until the capacity suffices.
      observed().waits = 0;
      // Other ratios of the charges make the last solution a bad initial guess.
      for (std::size_t g = 0; g < scene.problem.groups.size(); ++g)
        scene.problem.groups[g].charge +=
            scene.problem.groups[g].floating ? 1.0 + static_cast<double>((3 * g + k) % 5) : 0;
      CHECK(solver->solve(scene.problem).iterations > 4);
    }
    CHECK(observed().waits == scene.waits);
  }
}

namespace {

/// Problem in which half of the groups are coupled, each to the previous group or to the first one.
LaplaceProblem with_couplings(LaplaceProblem problem, double capacitance, bool chain) {
  for (int g = 1; g <= static_cast<int>(problem.groups.size()) / 2; ++g)
    problem.couplings.push_back({chain ? g - 1 : 0, g, capacitance * problem.permittivity});
  return problem;
}

/// Problem whose only ground is a supply coupled to the last group.
LaplaceProblem with_supply(LaplaceProblem problem, double capacitance) {
  problem.couplings.push_back(
      {static_cast<int>(problem.groups.size()) - 1, static_cast<int>(problem.groups.size()), capacitance});
  problem.groups.push_back({.floating = false, .potential = 3});
  return problem;
}

}  // namespace

TEST_CASE("device algorithms: lumped capacitances of any size as on the CPU") {
  CutCellOptions options;
  options.cells = 96;
  options.tolerance = 1e-9;
  for (const double capacitance : {1e-12, 1e-3, 0.06, 1.0, 1e3, 1e12}) {
    CAPTURE(capacitance);
    const LaplaceProblem scenes[] = {
        with_couplings(random_disks(25, 0.6), capacitance, true),
        with_couplings(random_disks(35, 0.01), capacitance, false),
        with_couplings(insulated(), capacitance, true),
        with_supply(with_couplings(insulated(), capacitance, true), std::max(capacitance, 1e-3)),
        with_couplings(chain(12, 1e-6), capacitance, true),
        with_couplings(narrow_box(), capacitance, true)};
    for (LaplaceProblem problem : scenes) {
      CAPTURE(problem.bodies.size());
      CAPTURE(problem.groups.size());
      options.cells = static_cast<int>(problem.size.x);
      CutCellSolver cpu(options);
      const std::unique_ptr<device::DeviceSolver> device = device::make_host_solver(options);
      for (int step = 0; step < 3; ++step) {  // The second and third solve use a history of another capacitance.
        CAPTURE(step);
        const LaplaceSolution a = cpu.solve(problem), b = device->solve(problem);
        CHECK(b.iterations <= a.iterations + 4 + a.iterations / 3);  // Coarse grids use one sweep instead of two.
        CHECK(difference(b, a) < 2e-7);                              // As above.
        double largest = 0;
        for (const double q : a.body_charge) largest = std::max(largest, std::abs(q));
        for (std::size_t k = 0; k < a.body_charge.size(); ++k)
          CHECK(std::abs(b.body_charge[k] - a.body_charge[k]) < 2e-6 * largest);
        for (laplace::Coupling& coupling : problem.couplings) coupling.capacitance *= 0.9;
      }
    }
  }
}

TEST_CASE("device algorithms: lumped capacitances conserve charge at tolerance 1e-2") {
  for (const double capacitance : {1e-3, 1.0, 1e12}) {
    CAPTURE(capacitance);
    CutCellOptions options;
    options.cells = 96;
    options.tolerance = 1e-2;
    LaplaceProblem problem = with_couplings(random_disks(35, 0.01), capacitance, true);
    problem.couplings.erase(problem.couplings.begin());  // The coupling of the ground.
    const LaplaceSolution found = device::make_host_solver(options)->solve(problem);
    double given = 0, sum = 0, largest = 0;
    for (std::size_t g = 1; g < problem.groups.size(); ++g) given += problem.groups[g].charge;
    for (std::size_t body = 1; body < problem.bodies.size(); ++body) {
      sum += found.body_charge[body];
      largest = std::max(largest, std::abs(found.body_charge[body]));
    }
    CHECK(std::abs(sum - given) < 1e-11 * largest);  // Rounding, as above.
  }
}

TEST_CASE("device algorithms: lumped capacitances may change from solve to solve") {
  CutCellOptions options;
  options.cells = 96;
  options.tolerance = 1e-10;
  const std::unique_ptr<device::DeviceSolver> device = device::make_host_solver(options);
  const LaplaceProblem separated = random_disks(25, 0.6);
  for (const LaplaceProblem& problem : {separated, with_couplings(separated, 1, true),
                                        with_couplings(with_couplings(separated, 1, true), 1e3, false), separated})
    CHECK(difference(device->solve(problem), CutCellSolver(options).solve(problem)) < 2e-8);
}

TEST_CASE("device kernels: recorded once despite merges, splits and capacitances") {
  CutCellOptions options;
  options.cells = 96;
  const LaplaceProblem separated = insulated();
  for (const bool has_supply : {false, true}) {
    CAPTURE(has_supply);
    const auto solver = device::make_host_solver(options);
    for (int step = 0; step < 30; ++step) {
      if (step == 15) {  // Here the capacity suffices, and each initial guess has been made once.
        CHECK(observed().recordings > 0);
        observed().recordings = 0;
      }
      LaplaceProblem problem = separated;
      for (std::size_t body = 0; body < problem.bodies.size(); ++body)
        std::get<Disk>(problem.bodies[body].shape).centre += Vec2{0.01, -0.02} * (step % 7);
      if (step % 3 == 1) {
        problem.groups[2].charge += problem.groups.back().charge;
        problem.groups.pop_back();
        problem.bodies.back().group = 2;
      }
      problem = with_couplings(problem, 1 + 0.1 * (step % 4), step % 2);
      if (has_supply) problem = with_supply(problem, 0.5 + 0.1 * (step % 5));
      solver->solve(problem);
    }
    CHECK(observed().recordings == 0);
  }
}

TEST_CASE("device solver after forget(): gives the bits of a new solver") {
  CutCellOptions options;
  options.cells = 128;
  options.tolerance = 1e-8;
  const LaplaceProblem separated = chain(12, 8), close = chain(12, 1e-6);
  const std::unique_ptr<device::DeviceSolver> used = device::make_host_solver(options);
  used->solve(close);  // Clusters of strongly linked groups relax otherwise than separate groups.
  used->solve(separated);
  used->forget();
  for (const LaplaceProblem& problem : {separated, close, separated}) {
    const std::unique_ptr<device::DeviceSolver> fresh = device::make_host_solver(options);
    const LaplaceSolution found = used->solve(problem), expected = fresh->solve(problem);
    used->forget();
    CHECK(found.group_potential == expected.group_potential);
    CHECK(found.body_charge == expected.body_charge);
    CHECK(found.iterations == expected.iterations);
  }
}

TEST_CASE("device kernels: recorded again after absence of strong links" * doctest::test_suite("long")) {
  CutCellOptions options;
  options.cells = 64;
  options.tolerance = 1e-2;
  const LaplaceProblem separated = chain(2, 8), close = chain(2, 1e-6);
  const auto solver = device::make_host_solver(options);
  const auto solve = [&](const LaplaceProblem& problem, int times) {
    observed() = {};
    for (int k = 0; k < times; ++k) solver->solve(problem);
  };
  solve(close, 10);  // Repeats until the capacity suffices and each initial guess has been made once.
  for (int k = 0; k < 3; ++k) {
    solve(separated, device::solves_to_forget_strong_links - 1);
    CHECK(observed().recordings == 0);
    CHECK(observed().waits == 3 * (device::solves_to_forget_strong_links - 1));
    solve(close, 1);
    CHECK(observed().recordings == 0);
  }
  solve(separated, device::solves_to_forget_strong_links + 5);
  CHECK(observed().recordings > 0);
  solve(separated, 10);
  CHECK(observed().recordings == 0);
  CHECK(observed().waits == 10);
  CutCellOptions exact = options;
  exact.tolerance = 1e-8;
  solver->set_tolerance(exact.tolerance);
  CHECK(difference(solver->solve(close), CutCellSolver(exact).solve(close)) < 1000 * exact.tolerance);  // As above.
  solve(close, 10);
  solve(close, 1);
  CHECK(observed().recordings == 0);
  CHECK(observed().waits == 3);
}

TEST_CASE("clusters_of: inverse is accurate although one link is 1e11 times larger") {
  // Three nodes in a row with links of 1e12 and 8; the fourth node is isolated.
  const std::vector<double> ground{1, 0.5, 2, 3};
  const std::vector<NetworkLink> links{{1, 0, 1e12}, {1, 2, 8}};
  const std::vector<double> diagonal{1 + 1e12, 0.5 + 8 + 1e12, 2 + 8, 3};
  const device::Clusters clusters = device::clusters_of({diagonal, links}, 64);
  CHECK(clusters.row == std::vector<int>{0, 1, 2, -1});
  CHECK(clusters.group == std::vector<int>{0, 1, 2});
  REQUIRE(clusters.inverse.size() == 9);
  // The equivalent network has one node with 1.5 to the ground, a link of 8 and one of 2: (8 + 2) / (1.5 * 10 + 16)
  // between the first node and itself. The ground conductance is a difference from the diagonals; 1e12 leaves four
  // digits of it.
  CHECK(clusters.inverse[0] == doctest::Approx(10.0 / 31).epsilon(1e-3));
  CHECK(clusters.inverse[8] == doctest::Approx(9.5 / 31).epsilon(1e-3));
  for (int k = 0; k < 3; ++k)
    for (int m = 0; m < 3; ++m)  // Rounding.
      CHECK(clusters.inverse[3 * k + m] == doctest::Approx(clusters.inverse[3 * m + k]).epsilon(1e-14));
  const device::Clusters pairs = device::clusters_of({diagonal, links}, 2);
  CHECK(pairs.row == std::vector<int>{0, 1, -1, -1});
}

TEST_CASE("LinkedGroups: clusters of linked groups equal clusters of all groups") {
  // Among nine groups the second has no unknown, and the fifth and the last have no links.
  const std::vector<double> diagonal{3, 0, 1 + 1e3, 2 + 40, 5, 2 + 1e3 + 40, 1 + 7, 6 + 7, 4};
  const std::vector<NetworkLink> links{{5, 2, 1e3}, {0, 1, 50}, {3, 5, 40}, {7, 6, 7}};
  const device::Clusters all = device::clusters_of({diagonal, links}, 64);
  std::vector<int> slot_of_group;
  for (int k = 0; k < 2; ++k) {  // the same memory
    device::LinkedGroups linked = device::LinkedGroups::of(diagonal, links, slot_of_group);
    CHECK(linked.group == std::vector<int>{2, 3, 5, 6, 7});
    device::Clusters clusters = device::clusters_of(std::move(linked.network), 64);
    for (int& g : clusters.group) g = linked.group[g];
    CHECK(clusters.group == all.group);
    CHECK(clusters.first == all.first);
    CHECK(clusters.start == all.start);
    CHECK(clusters.inverse == all.inverse);
    REQUIRE(all.group.size() == 5);
  }
}

namespace {

/// Problem of `count` disks of radius 0.1 cells on a grid of 8 x 8, in three groups that interpenetrate. The potential
/// of the first group is given.
LaplaceProblem three_thin_groups(int count) {
  random_placement::Random random(7);
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {16, 16};
  problem.sides[bottom].kind = Side::Kind::electrode;
  problem.groups = {{false, 0, 0.5}, {true, 1, 0}, {true, -1, 0}};
  for (int k = 0; k < count; ++k) problem.bodies.push_back({Disk{{random(0.2, 15.8), random(0.2, 15.8)}, 0.2}, k % 3});
  return problem;
}

/// Coarse grid as in the V-cycle.
struct CoarseGrid {
  CoarseGrid(const LaplaceProblem& problem, int n)
      : on_device(run), grid(run, n, n, problem.size.x / n, LinkFormula::log_fitted, false) {
    on_device.upload(problem, n, n);
    do {
      grid.enlarge(on_device.view(), required);
      grid.reserve(on_device.view(), {.has_medium = true, .number = number.data(), .required = required.data()});
      grid.outline(on_device.view(), nullptr);
      grid.build(on_device.view());
    } while (!grid.fits(required));
  }
  parallel::HostExecutor run;
  device::Numbers number{}, required{};
  device::DeviceProblem<parallel::HostExecutor> on_device;
  device::DeviceGrid<parallel::HostExecutor> grid;
};

}  // namespace

TEST_CASE("device grid: subgrid conductors of a group between four cells are merged") {
  const LaplaceProblem problem = three_thin_groups(600);
  const int n = 8;
  const CoarseGrid coarse(problem, n);
  const device::GridView& grid = coarse.grid.view();
  const bool electrode[4] = {false, false, true, false};
  const int cells = static_cast<int>(grid.layout.size());
  std::vector<double> expected(3 * cells, 0.0), links(3 * cells, 0.0), seen_from_cells(3 * cells, 0.0);
  for (const Body& body : problem.bodies) {
    const Outline disk = outline_in_cells(body.shape, grid.h);
    const Interpolation around = interpolate(grid.layout, disk.centre, electrode);
    for (int k = 0; k < 4; ++k)
      expected[body.group * cells + around.cell[k]] +=
          std::abs(around.weight[k]) * subgrid_conductance(disk, grid.layout);
  }
  std::vector<int> links_by_cell(3 * cells, 0);
  for (int m = 0; m < grid.number[device::Items::links]; ++m) {
    const int at = grid.links.group[m] * cells + grid.links.slot[m];
    links[at] += grid.links.conductance[m];
    CHECK(++links_by_cell[at] <= 4);  // From the four bins around a cell; 600 disks would have about ten.
  }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i)
      device::gathered(grid.layout, grid.medium.subgrid_conductors, i, j, [&](int group, float conductance) {
        seen_from_cells[group * cells + device::slot_of(grid.layout, i, j)] += conductance;
        return 0.0f;
      });
  double largest = 0;
  for (const double c : expected) largest = std::max(largest, c);
  for (std::size_t k = 0; k < expected.size(); ++k) {  // Single precision, sums of at most about 30 terms.
    REQUIRE(std::abs(links[k] - expected[k]) <= 30 * 6e-8 * largest);
    REQUIRE(std::abs(seen_from_cells[k] - links[k]) <= 30 * 6e-8 * largest);
  }
}

TEST_CASE("invert_in_panels: inverts up to 200 nodes, detects singular matrices") {
  parallel::HostExecutor run;
  random_placement::Random random(3);
  for (const int n : {1, 32, 33, 200}) {
    CAPTURE(n);
    const int capacity = n + 7;
    std::vector<double> matrix(capacity * capacity, 7.0), inverse(capacity * capacity, 7.0),
        scratch(device::Panel::scratch(capacity));
    for (int a = 0; a < n; ++a) matrix[a * n + a] = 0.5;  // Conductance to the ground.
    for (int a = 0; a < n; ++a)
      for (int b = 0; b < a; ++b) {
        const double conductance = random(0, 1);
        matrix[a * n + b] = matrix[b * n + a] = -conductance;
        matrix[a * n + a] += conductance;
        matrix[b * n + b] += conductance;
      }
    device::Numbers number{};
    number[device::Items::coarse_unknowns] = n;
    device::GridView grid{};
    grid.number = number.data();
    int is_singular = 0;
    device::CoarsestView coarsest{};
    coarsest.matrix = matrix.data();
    coarsest.precise_inverse = inverse.data();
    coarsest.is_singular = &is_singular;
    coarsest.scratch = scratch.data();
    for (const bool pin : {false, true}) {
      device::invert_in_panels(run, grid, coarsest, capacity, pin);
      CHECK(is_singular == 0);
      double worst = 0;
      for (int a = 0; a < n; ++a)
        for (int b = 0; b < n; ++b) {
          double sum = a == b ? -1.0 : 0.0;
          for (int c = 0; c < n; ++c)
            sum += matrix[a * n + c] * (pin && a == n - 1 && c == n - 1 ? 2 : 1) * inverse[c * n + b];
          worst = std::max(worst, std::abs(sum));
        }
      // The eigenvalues lie between 0.5 and n: rounding of sums of n terms, times n / 0.5.
      CHECK(worst < 1.1e-16 * n * n / 0.5 + 1e-15);
    }
    matrix[0] = 0;  // The first node has no connection.
    for (int b = 1; b < n; ++b) matrix[b] = matrix[b * n] = 0;
    device::invert_in_panels(run, grid, coarsest, capacity, false);
    CHECK(is_singular == 1);
  }
}

TEST_CASE("device algorithms, large coarsest grid: gaps of 1e-6 converge as on CPU") {
  // 60, 30 and 15 cells per side.
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {60, 60};
  problem.sides[left].kind = Side::Kind::electrode;
  for (int k = 0; k < 6; ++k) {
    problem.bodies.push_back({Disk{{10.2 + k * (6 + 1e-6), 30.3}, 3}, k});
    problem.groups.push_back({true, k == 0 ? 1.0 : 0.0, 0});
  }
  CutCellOptions options;
  options.cells = 60;
  options.tolerance = 1e-8;
  const LaplaceSolution a = CutCellSolver(options).solve(problem);
  const std::unique_ptr<device::DeviceSolver> device = device::make_host_solver(options);
  for (int k = 0; k < 2; ++k) {  // The second solve uses clusters.
    device->forget();
    const LaplaceSolution b = device->solve(problem);
    CHECK(b.iterations <= a.iterations + 2 + a.iterations / 3);
    CHECK(difference(b, a) < 1000 * options.tolerance);  // As above.
  }
}

}  // namespace device_groups_test
