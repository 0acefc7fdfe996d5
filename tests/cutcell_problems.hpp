#pragma once

#include <numbers>

#include "solvers/laplace/cutcell/solver.hpp"
#include "tests/random_placement.hpp"

/// Problems for the cut-cell solver and its parts.
namespace lichtenberg::cutcell_problems {

using namespace laplace;

constexpr double pi = std::numbers::pi;

/// `count` disks of radius `radius` in a box of side `side`, with gaps of at least `least_gap`, around a grounded
/// half-disk on the bottom. Charges alternate in size and sign.
inline LaplaceProblem random_disks(int count, double side, double radius, double least_gap) {
  random_placement::Random random(7);
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {side, side};
  problem.bodies = {{Disk{{0.5 * side, 0}, 2 * radius}, 0}};
  problem.groups = {{false, 0, 0}};
  while (static_cast<int>(problem.bodies.size()) <= count) {
    const Disk disk{{random(radius + 1, side - radius - 1), random(radius + 1, side - radius - 1)}, radius};
    random_placement::add_if_free(problem, disk, least_gap, random);
  }
  return problem;
}

inline CutCellOptions options(int cells, double tolerance = 1e-10) {
  CutCellOptions o;
  o.cells = cells;
  o.tolerance = tolerance;
  return o;
}

}  // namespace lichtenberg::cutcell_problems
