#pragma once

#include <numbers>
#include <random>

#include "solvers/laplace/cutcell/solver.hpp"

/// Problems for the cut-cell solver and its parts.
namespace lichtenberg::cutcell_problems {

using namespace laplace;

constexpr double pi = std::numbers::pi;

struct Random {
  std::mt19937_64 generator{7};
  double operator()(double from, double to) {
    return from + (to - from) * static_cast<double>(generator() >> 11) * 0x1p-53;
  }
};

/// `count` disks of radius `radius` in a box of side `side`, surfaces at least `least_gap` apart, around a grounded
/// half-disk on the bottom; charges alternate in size and sign.
inline LaplaceProblem crowd(int count, double side, double radius, double least_gap) {
  Random random;
  LaplaceProblem problem;
  problem.size = {side, side};
  problem.bodies = {{Disk{{0.5 * side, 0}, 2 * radius}, 0}};
  problem.groups = {{false, 0, 0}};
  while (static_cast<int>(problem.bodies.size()) <= count) {
    const Disk disk{{random(radius + 1, side - radius - 1), random(radius + 1, side - radius - 1)}, radius};
    bool free = true;
    for (const Body& body : problem.bodies) free = free && gap(disk, body.shape) > least_gap;
    if (!free) continue;
    problem.bodies.push_back({disk, static_cast<int>(problem.groups.size())});
    problem.groups.push_back({true, random(-1, 1), 0});
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
