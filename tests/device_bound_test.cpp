// Tests of the iterations with eliminated near-surface cells in the device's algorithms, executed by the CPU item by
// item.

#include <doctest/doctest.h>

#include <algorithm>

#include "solvers/laplace/cutcell/device/device.hpp"
#include "solvers/laplace/cutcell/solver.hpp"
#include "validation/hard_cases/random_scenes.hpp"

namespace device_bound_test {

using namespace lichtenberg;
using namespace lichtenberg::laplace;

TEST_CASE("device algorithms on the CPU: at most 24 iterations for random scenes") {
  // The bound of validation/hard_cases. Without elimination of near-surface cells, 38 and 8 of the scenes need more
  // than 24.
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    CAPTURE(seed);
    const LaplaceProblem problem = validation::SceneMaker(seed).make();
    CutCellOptions options;
    options.cells = static_cast<int>(std::max(problem.size.x, problem.size.y));
    options.tolerance = 1e-8;
    CHECK(device::make_host_solver(options)->solve(problem).iterations <= 24);
  }
}

TEST_CASE("device algorithms, gaps at cell centres: iterations near the CPU's") {
  for (const double gap : {1e-6, 0.01}) {
    CAPTURE(gap);
    LaplaceProblem problem{.permittivity = 1};
    problem.size = {128, 128};
    problem.sides[left].kind = Side::Kind::electrode;
    for (int k = 0; k < 60; ++k) {
      problem.bodies.push_back({Disk{{10 + (1.8 + gap) * k, 64.3}, 0.9}, k});
      problem.groups.push_back({.floating = true, .charge = 1.0 + k % 3});
    }
    CutCellOptions options;
    options.cells = 128;
    options.tolerance = 1e-8;
    const LaplaceSolution a = CutCellSolver(options).solve(problem);
    const std::unique_ptr<device::DeviceSolver> device = device::make_host_solver(options);
    for (int k = 0; k < 2; ++k) {  // Without elimination 47 instead of 9.
      device->forget();
      const LaplaceSolution b = device->solve(problem);
      CHECK(b.iterations <= a.iterations + 4 + a.iterations / 3);  // Coarse grids use one sweep instead of two.
      double worst = 0, largest = 0;
      for (std::size_t g = 0; g < a.group_potential.size(); ++g) {
        worst = std::max(worst, std::abs(b.group_potential[g] - a.group_potential[g]));
        largest = std::max(largest, std::abs(a.group_potential[g]));
      }
      CHECK(worst < 1000 * options.tolerance * largest);  // As in cutcell_test.
    }
  }
}

}  // namespace device_bound_test
