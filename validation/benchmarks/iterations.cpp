// Counts CG iterations of the cut-cell solver to 1e-8 from a zero initial guess, as a function of cells per side S,
// number of conductors N and narrowest gap. Half of the disks are at random positions; each of the others has that gap
// to an earlier one. The disks cover a sixth of the box. The bound is 12.
//
//   benchmark_iterations [--sizes 128,512] [--conductors 1,324] [--gaps 2,0.01] [--seed 1]

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>

#include "solvers/laplace/cutcell/solver.hpp"

using namespace lichtenberg;
using namespace lichtenberg::laplace;

namespace {

constexpr int bound = 12;

/// Returns `count` disks in a box of `side` cells with a grounded half-disk at the bottom. Gaps are at least
/// `least_gap`, and every other disk has exactly that gap to another one. Empty if they do not fit.
std::optional<LaplaceProblem> scene(int side, int count, double least_gap, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  const auto uniform = [&](double from, double to) {
    return from + (to - from) * static_cast<double>(generator() >> 11) * 0x1p-53;
  };
  const double radius = side * std::sqrt(1.0 / 6 / std::numbers::pi / count);
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {static_cast<double>(side), static_cast<double>(side)};
  problem.bodies = {{Disk{{0.5 * side, 0}, side / 32.0}, 0}};
  problem.groups = {{false, 0, 0}};
  const double cell = 2 * radius + least_gap;  // of the table for neighbour search
  const int columns = std::max(1, static_cast<int>(side / cell));
  std::vector<std::vector<Disk>> table(columns * columns);
  const auto column = [&](double x) { return std::clamp(static_cast<int>(x / side * columns), 0, columns - 1); };
  const auto is_free = [&](const Disk& disk) {
    const Vec2 c = disk.centre;
    if (std::min(c.x, c.y) < radius + 1 || std::max(c.x, c.y) > side - radius - 1) return false;
    if (gap(disk, problem.bodies[0].shape) < least_gap) return false;
    for (int j = std::max(0, column(c.y) - 1); j <= std::min(columns - 1, column(c.y) + 1); ++j)
      for (int i = std::max(0, column(c.x) - 1); i <= std::min(columns - 1, column(c.x) + 1); ++i)
        for (const Disk& other : table[j * columns + i])
          if (norm(other.centre - c) - 2 * radius < least_gap * (1 - 1e-9)) return false;
    return true;
  };
  std::vector<Disk> disks;
  for (int tries = 0; static_cast<int>(disks.size()) < count; ++tries) {
    if (tries > 1000 * count) return std::nullopt;
    Disk disk{{uniform(radius, side - radius), uniform(radius, side - radius)}, radius};
    if (disks.size() % 2 == 1) {
      const double angle = uniform(0, 2 * std::numbers::pi);
      const Disk& beside = disks[generator() % disks.size()];
      disk.centre = beside.centre + (2 * radius + least_gap) * Vec2{std::cos(angle), std::sin(angle)};
    }
    if (!is_free(disk)) continue;
    disks.push_back(disk);
    table[column(disk.centre.y) * columns + column(disk.centre.x)].push_back(disk);
    problem.bodies.push_back({disk, static_cast<int>(problem.groups.size())});
    problem.groups.push_back({true, uniform(-1, 1), 0});
  }
  return problem;
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<int> sizes{128, 256, 512, 1024, 2048, 4096}, conductors{1, 9, 36, 100, 324, 1000, 5000};
  std::vector<double> gaps{2, 0.3, 0.1, 0.03, 0.01};
  std::uint64_t seed = 1;
  CLI::App app("Counts the field solver's iterations");
  app.add_option("--sizes", sizes, "cells along a side")->delimiter(',');
  app.add_option("--conductors", conductors, "their numbers")->delimiter(',');
  app.add_option("--gaps", gaps, "narrowest gaps, in cells")->delimiter(',');
  app.add_option("--seed", seed, "of the configurations");
  CLI11_PARSE(app, argc, argv);

  fmt::print("{:>5} {:>5} {:>6}  iterations at gap", "S", "N", "R");
  for (const double gap : gaps) fmt::print(" {:>5}", gap);
  fmt::print("\n");
  int worst = 0;
  for (const int side : sizes)
    for (const int count : conductors) {
      fmt::print("{:5d} {:5d} {:6.2f}                   ", side, count,
                 side * std::sqrt(1 / (6 * std::numbers::pi * count)));
      for (const double gap : gaps) {
        const std::optional<LaplaceProblem> problem = scene(side, count, gap, seed);
        if (!problem) {
          fmt::print(" {:>5}", "-");
          continue;
        }
        CutCellSolver solver({.cells = side});
        const int iterations = solver.solve(*problem).iterations;
        worst = std::max(worst, iterations);
        fmt::print(" {:5d}{}", iterations, iterations > bound ? "!" : " ");
        std::fflush(stdout);
      }
      fmt::print("\n");
    }
  fmt::print("most: {}, bound {}\n", worst, bound);
  return worst > bound;
}
