#pragma once

// Scene of the field benchmarks.

#include <algorithm>
#include <cstdint>
#include <random>

#include "solvers/laplace/problem.hpp"

namespace lichtenberg::benchmarks {

/// Makes a random field problem for benchmarks: `conductors` floating disks of a radius, by default S/64, around a
/// grounded half-disk on the bottom of a square box of side S. Gaps are at least a quarter of the radius, charges
/// between 0 and 1. Lengths are in cells, S = 512.
inline laplace::LaplaceProblem disks_round_ground(int conductors, std::uint64_t seed, double radius = 8) {
  using namespace laplace;
  constexpr double side = 512;
  const double least_gap = 0.25 * radius;
  std::mt19937_64 generator(seed);
  const auto uniform = [&](double from, double to) {
    return from + (to - from) * static_cast<double>(generator() >> 11) * 0x1p-53;
  };
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {side, side};
  problem.bodies = {{Disk{{0.5 * side, 0}, 2 * radius}, 0}};
  problem.groups = {{false, 0, 0}};
  while (static_cast<int>(problem.bodies.size()) <= conductors) {
    const Disk disk{{uniform(radius + 1, side - radius - 1), uniform(radius + 1, side - radius - 1)}, radius};
    const bool free = std::all_of(problem.bodies.begin(), problem.bodies.end(),
                                  [&](const Body& body) { return gap(disk, body.shape) > least_gap; });
    if (!free) continue;
    problem.bodies.push_back({disk, static_cast<int>(problem.groups.size())});
    problem.groups.push_back({true, uniform(0, 1), 0});
  }
  return problem;
}

}  // namespace lichtenberg::benchmarks
