#pragma once

// Random scenes on small grids: solutions must not diverge and must satisfy general properties.

#include <exception>
#include <limits>

#include "validation/hard_cases/common.hpp"

namespace lichtenberg::validation {

/// Generator of random field problems: draws box, sides, disks, groups and charges from one seed.
class SceneMaker {
 public:
  explicit SceneMaker(std::uint64_t seed) : random_(seed) {}

  LaplaceProblem make() {
    draw_box();
    draw_disks();
    draw_charges();
    return problem_;
  }

 private:
  double uniform(double from, double to) { return std::uniform_real_distribution<double>(from, to)(random_); }
  double decades(double from, double to) { return std::pow(10.0, uniform(from, to)); }
  int whole(int from, int to) { return std::uniform_int_distribution<int>(from, to)(random_); }
  bool chance(double p) { return uniform(0, 1) < p; }

  /// Draws a box of 32 to 128 cells, mostly a number divisible by 16, with aspect ratios up to eight.
  void draw_box() {
    const int longer = chance(0.75) ? 16 * whole(2, 8) : whole(32, 128);
    const int shorter = chance(0.5) ? longer : std::max(8, longer / whole(1, 8));
    problem_.size = chance(0.5) ? Vec2(longer, shorter) : Vec2(shorter, longer);
    for (Side& side : problem_.sides)
      if (chance(0.5)) side = {.kind = Side::Kind::electrode, .potential = chance(0.5) ? 0 : uniform(-1, 1)};
  }

  /// Draws disks with radii from 0.05 cell to a quarter of the box, covering up to half of the area. Every other disk
  /// has a gap of 1e-7 to 3 R to another disk or to a side.
  void draw_disks() {
    const double width = std::min(problem_.size.x, problem_.size.y), area = problem_.size.x * problem_.size.y;
    const double smallest = std::min(decades(-1.3, 1), width / 5);
    const double largest = std::min(smallest * decades(0, 1), width / 4);
    const double fixed = chance(0.5) ? 0.1 : 0, joining = uniform(0, 0.6);
    double to_cover = uniform(0, 0.5) * area;
    for (int attempt = 0; attempt < 400 && to_cover > 0 && problem_.bodies.size() < 200; ++attempt) {
      const double radius = smallest * std::pow(largest / smallest, uniform(0, 1));
      const Disk disk{random_centre(radius), radius};
      if (!free(disk)) continue;
      to_cover -= pi * radius * radius;
      if (!problem_.groups.empty() && chance(joining))
        problem_.bodies.push_back({disk, whole(0, static_cast<int>(problem_.groups.size()) - 1)});
      else
        add(problem_, disk, {.floating = !chance(fixed), .potential = uniform(-1, 1)});
    }
    if (problem_.bodies.empty()) add(problem_, {0.5 * problem_.size, smallest}, {});
  }

  Vec2 random_centre(double radius) {
    const Vec2 anywhere{uniform(0, problem_.size.x), uniform(0, problem_.size.y)};
    const double gap = radius * decades(-7, 0.5);
    if (chance(0.1)) return {anywhere.x, radius + gap};
    if (problem_.bodies.empty() || chance(0.5)) return anywhere;
    const Disk& other = disk_of(problem_, whole(0, static_cast<int>(problem_.bodies.size()) - 1));
    const double angle = uniform(0, 2 * pi);
    return other.centre + (other.radius + radius + gap) * Vec2{std::cos(angle), std::sin(angle)};
  }

  bool free(const Disk& disk) const {
    const Vec2 c = disk.centre, far = problem_.size - c;
    if (std::min({c.x, c.y, far.x, far.y}) <= disk.radius) return false;
    return std::all_of(problem_.bodies.begin(), problem_.bodies.end(),
                       [&](const Body& body) { return gap(disk, body.shape) > 0; });
  }

  /// Draws charges: all 0, up to 1, or from 1e-20 to 1e+3 in magnitude; they cancel if nothing is grounded.
  void draw_charges() {
    const int kind = whole(0, 3);
    for (Group& group : problem_.groups)
      if (kind > 0) group.charge = kind == 3 ? std::copysign(decades(-20, 3), uniform(-1, 1)) : uniform(-1, 1);
    if (problem_.has_ground()) return;
    problem_.groups.back().charge = 0;
    double total = 0;
    for (const Group& group : problem_.groups) total += group.charge;
    problem_.groups.back().charge = -total;
  }

  std::mt19937_64 random_;
  LaplaceProblem problem_{.permittivity = 1};
};

/// Tests the maximum principle: computes the largest excess of a cell potential beyond the range of the conductors' and
/// sides' potentials, relative to the largest of these potentials. 0 if there is none; infinite if a potential is not
/// finite.
inline double beyond_extremes(const LaplaceProblem& problem, const LaplaceSolution& solution, const Field& field) {
  double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
  const auto include = [&](double potential) {
    lowest = std::min(lowest, potential);
    highest = std::max(highest, potential);
  };
  for (const double phi : solution.group_potential) include(phi);
  for (const Side& side : problem.sides)
    if (side.kind == Side::Kind::electrode) include(side.potential);
  double beyond = 0;
  for (const double v : field.value) {
    if (!std::isfinite(v)) return std::numeric_limits<double>::infinity();
    beyond = std::max({beyond, v - highest, lowest - v});
  }
  return beyond > 0 ? beyond / std::max(std::abs(lowest), std::abs(highest)) : 0.0;
}

/// Computes the asymmetry of a capacitance matrix: max |C_ij - C_ji| / sqrt(C_ii C_jj).
inline double asymmetry(const std::vector<double>& capacitance) {
  const auto n = static_cast<std::size_t>(std::lround(std::sqrt(static_cast<double>(capacitance.size()))));
  double worst = 0;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < i; ++j)
      worst = std::max(worst, std::abs(capacitance[i * n + j] - capacitance[j * n + i]) /
                                  std::sqrt(capacitance[i * n + i] * capacitance[j * n + j]));
  return worst;
}

/// Solves `count` random problems by the cut-cell method, and tests convergence, charge balance, maximum principle and
/// symmetry of the capacitance matrix.
/// Bounds: extreme gaps and radii may be expensive but must converge. Conjugate gradients need sqrt(kappa) / 2 ln(2 /
/// tolerance) = 9.6 sqrt(kappa) iterations, or 24 for a preconditioned condition number kappa of 6.25. The error of a
/// potential is at most the tolerance times the solution's energy norm. The error of a charge is this times the root of
/// the conductance of its links. With links to grounded sides, about 1e4 cell faces on these grids, that root is 100.
inline void random_scenes(Report& report, int count) {
  report.section(fmt::format("{} random scenes", count));
  constexpr double tolerance = 1e-8;
  int failures = 0;
  SampleBySeed iterations, imbalance, beyond, asymmetries;
  for (int k = 0; k < count; ++k) {
    const auto seed = static_cast<std::uint64_t>(k);
    const LaplaceProblem problem = SceneMaker(seed).make();
    const int cells = static_cast<int>(std::max(problem.size.x, problem.size.y));
    try {
      CutCellSolver solver({.cells = cells, .tolerance = tolerance});
      const LaplaceSolution solution = solver.solve(problem);
      iterations.add(solution.iterations, seed);
      imbalance.add(charge_imbalance(problem, solution), seed);
      beyond.add(beyond_extremes(problem, solution, solver.field()), seed);
      const std::size_t groups = problem.groups.size();
      if (groups > 1 && groups <= 5) asymmetries.add(asymmetry(capacitance_matrix(solver, problem)), seed);
    } catch (const std::exception& error) {
      ++failures;
      fmt::print("seed {}: {}\n", seed, error.what());
    }
  }
  report.at_most("without a solution", failures, 0);
  report.at_most("iterations", spread(iterations.values), 24, iterations.note());
  report.at_most("charge balance", spread(imbalance.values), 1e-10, imbalance.note());
  report.at_most("potentials beyond the extremes, of the largest", spread(beyond.values), 100 * tolerance,
                 beyond.note());
  report.at_most(fmt::format("asymmetry of {} capacitance matrices", asymmetries.values.size()),
                 spread(asymmetries.values), 100 * tolerance, asymmetries.note());
}

}  // namespace lichtenberg::validation
