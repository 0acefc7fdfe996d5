// Counts CG iterations of the cut-cell solver to 1e-8 from a zero initial guess. Parameters: coupling capacitance
// between conductors (in units of the permittivity), pattern of the couplings, grounding of the field. The disks have
// radius S/64 at random positions: for S < 128 and on all coarse grids they are smaller than cells.
//
//   benchmark_couplings [--cells 512] [--conductors 324] [--capacitances 0,1,1e6] [--assembled]

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <random>
#include <string>

#include "solvers/laplace/cutcell/solver.hpp"
#include "validation/benchmarks/scene.hpp"

using namespace lichtenberg;
using namespace lichtenberg::laplace;

namespace {

enum class Ground { body, sides, supply, none };
enum class Pattern { pairs, chain, tree, star, neighbours };

/// Returns disks around a half-disk, body 0. It is fixed, floats with a charge that neutralizes the scene, or is
/// coupled to a potential source by `capacitance`.
LaplaceProblem grounded(int conductors, Ground ground, double capacitance) {
  LaplaceProblem problem = benchmarks::disks_round_ground(conductors, 3);
  if (ground == Ground::body) return problem;
  problem.groups[0] = {};
  if (ground == Ground::none)
    for (int g = 1; g <= conductors; ++g) problem.groups[0].charge -= problem.groups[g].charge;
  if (ground == Ground::sides) {
    problem.sides[bottom] = {Side::Kind::electrode, 0, nullptr};
    problem.sides[top] = {Side::Kind::electrode, 30, nullptr};
  }
  if (ground == Ground::supply) {
    problem.couplings.push_back({0, conductors + 1, std::max(capacitance, 1e-12)});
    problem.groups.push_back({.floating = false, .potential = 100});
  }
  return problem;
}

void couple(LaplaceProblem& problem, int conductors, Pattern pattern, double capacitance) {
  std::mt19937_64 generator(5);
  const auto disk = [&](int body) { return std::get<Disk>(problem.bodies[body].shape); };
  for (int k = 2; k <= conductors; ++k) {
    const auto to = [&](int other) { problem.couplings.push_back({other, k, capacitance}); };
    if (pattern == Pattern::pairs && k % 2 == 0) to(k - 1);
    if (pattern == Pattern::chain) to(k - 1);
    if (pattern == Pattern::tree) to(1 + static_cast<int>(generator() % (k - 1)));
    if (pattern == Pattern::star) to(1);
    if (pattern != Pattern::neighbours) continue;
    for (int other = 1; other < k; ++other)
      if (gap(disk(k), problem.bodies[other].shape) < disk(k).radius) to(other);
  }
}

}  // namespace

int main(int argc, char** argv) {
  int cells = 512, conductors = 324;
  std::vector<double> capacitances{0, 1e-12, 1e-3, 0.03, 0.06, 0.3, 1, 10, 1e3, 1e6, 1e12};
  bool assembled = false;
  CLI::App app("Counts the field solver's iterations over how strongly conductors are coupled");
  app.add_option("--cells", cells, "cells along a side");
  app.add_option("--conductors", conductors, "their number");
  app.add_option("--capacitances", capacitances, "of a coupling, in units of the permittivity")->delimiter(',');
  app.add_flag("--assembled", assembled, "the assembled system under GAMG");
  CLI11_PARSE(app, argc, argv);

  const std::pair<Ground, const char*> grounds[] = {
      {Ground::body, "body"}, {Ground::sides, "sides"}, {Ground::supply, "supply"}, {Ground::none, "none"}};
  const std::pair<Pattern, const char*> patterns[] = {{Pattern::pairs, "pairs"},
                                                      {Pattern::chain, "chain"},
                                                      {Pattern::tree, "tree"},
                                                      {Pattern::star, "star"},
                                                      {Pattern::neighbours, "neighbours"}};
  CutCellOptions options{.cells = cells};
  if (assembled) options.linear_solver = CutCellOptions::LinearSolver::assembled;
  fmt::print("{:8} {:11}", "ground", "coupled as");
  for (const double capacitance : capacitances) fmt::print(" {:>6g}", capacitance);
  fmt::print("\n");
  for (const auto& [ground, ground_name] : grounds)
    for (const auto& [pattern, pattern_name] : patterns) {
      fmt::print("{:8} {:11}", ground_name, pattern_name);
      for (const double capacitance : capacitances) {
        LaplaceProblem problem = grounded(conductors, ground, capacitance);
        couple(problem, conductors, pattern, capacitance);
        fmt::print(" {:6d}", CutCellSolver(options).solve(problem).iterations);
        std::fflush(stdout);
      }
      fmt::print("\n");
    }
}
