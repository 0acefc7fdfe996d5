// Two equal disks in the plane: capacitance (D 6.37, figure 6.5) and force against the exact values, as functions of d
// / 2R and of R in cells, at random positions and directions on the grid.
//
//   two_disks          R = 4, 8, 16; a few seconds
//   two_disks long     R to 64

#include <memory>
#include <numbers>
#include <random>

#include "solvers/laplace/cutcell/solver.hpp"
#include "solvers/laplace/relaxation/solver.hpp"
#include "validation/harness.hpp"
#include "validation/program.hpp"

namespace two_disks_validation {

using namespace lichtenberg;
using namespace lichtenberg::validation;

namespace {

constexpr double charge = 1;

/// Returns the side of a box of whole cells (a multiple of 16, for the coarse grids) with a margin of two radii around
/// the pair.
double box_side(double radius, double ratio) { return 16 * std::ceil((2 * ratio + 6) * radius / 16); }

theory::DiskPair pair_at(Vec2 centre, double angle, double radius, double ratio) {
  const Vec2 half = radius * ratio * Vec2{std::cos(angle), std::sin(angle)};
  return {{centre - half, radius}, {centre + half, radius}, 1};
}

struct Errors {
  double capacitance, force;  ///< relative; the capacitance error has a sign
};
Errors errors(laplace::LaplaceSolver& solver, const theory::DiskPair& pair, double side) {
  const auto problem = in_plane(pair, {side, side}, charge);
  const auto solution = solver.solve(problem);
  const double capacitance = charge / (solution.group_potential[0] - problem.groups[1].potential);
  const Vec2 exact = theory::force(pair, charge);
  return {capacitance / theory::capacitance(pair) - 1, norm(solution.body_force[0] - exact) / norm(exact)};
}

struct Sample {
  Spread capacitance, force;  ///< percent
};
template <class MakeSolver>
Sample sample(const MakeSolver& make_solver, double radius, double ratio, int positions) {
  std::mt19937_64 random(20);
  std::uniform_real_distribution<double> fraction(0, 1);
  const double side = box_side(radius, ratio);
  const auto solver = make_solver(static_cast<int>(side));
  std::vector<double> capacitance, force;
  for (int k = 0; k < positions; ++k) {
    const Vec2 centre = Vec2{0.5 * side, 0.5 * side} + Vec2{fraction(random), fraction(random)};
    const Errors e = errors(*solver, pair_at(centre, std::numbers::pi * fraction(random), radius, ratio), side);
    solver->forget();
    capacitance.push_back(100 * e.capacitance);
    force.push_back(100 * e.force);
  }
  return {spread(capacitance), spread(force)};
}

/// Bounds at R = 8 in percent, worst over positions. Intermediate ratios have the bound of the next smaller stated
/// ratio; ratios below 1.05 have none.
struct Goal {
  double ratio, capacitance, force, jitter;
};
constexpr Goal goals[] = {{2, 0.02, 0.1, 0.02}, {1.25, 0.15, 0.6, 0.06}, {1.05, 1, 3.5, 1.5}};
const Goal* goal(double ratio) {
  const auto* found = std::find_if(std::begin(goals), std::end(goals), [&](const Goal& g) { return g.ratio <= ratio; });
  return found == std::end(goals) ? nullptr : found;
}

/// Orders are tested for d / 2R >= 1.25, where R = 4 leaves two cells in the gap.
template <class MakeSolver>
void convergence(Report& report, const MakeSolver& make_solver, const std::vector<double>& radii, int positions,
                 bool has_goal, double least_order) {
  for (const double ratio : {1.02, 1.05, 1.1, 1.25, 1.5, 2.0, 4.0, 8.0}) {
    std::vector<double> capacitance, force;
    for (const double radius : radii) {
      const Sample s = sample(make_solver, radius, ratio, positions);
      capacitance.push_back(s.capacitance.mean);
      force.push_back(s.force.mean);
      const Goal* g = has_goal && radius == 8 ? goal(ratio) : nullptr;
      const std::string label = fmt::format("d/2R = {:<4} R = {:<2}", ratio, radius);
      report.at_most(label + " capacitance", s.capacitance, g ? std::optional(g->capacitance) : std::nullopt);
      report.at_most(label + " force", s.force, g ? std::optional(g->force) : std::nullopt);
    }
    if (ratio < 1.25) continue;
    report.at_least(fmt::format("d/2R = {:<4} order of the capacitance", ratio), order(radii, capacitance),
                    least_order);
    report.at_least(fmt::format("d/2R = {:<4} order of the force", ratio), order(radii, force), least_order);
  }
}

/// Measures the force along a path of a few cells at R = 8 in steps of 0.037 cells: the grid's effect on a moving
/// conductor.
void jitter(Report& report) {
  const double radius = 8;
  for (const Goal& g : goals) {
    const double side = box_side(radius, g.ratio);
    laplace::CutCellSolver solver({.cells = static_cast<int>(side)});
    std::vector<double> along;
    for (int k = 0; k < 80; ++k) {
      const Vec2 centre = Vec2{0.5 * side, 0.5 * side} + 0.037 * k * Vec2{0.8, 0.6};
      const theory::DiskPair pair = pair_at(centre, 0.3, radius, g.ratio);
      const auto solution = solver.solve(in_plane(pair, {side, side}, charge));
      const Vec2 exact = theory::force(pair, charge);
      along.push_back(100 * dot(solution.body_force[0], exact) / norm2(exact));
    }
    report.at_most(fmt::format("d/2R = {:<4} R = 8  force, rms about its mean in %", g.ratio), spread(along).jitter,
                   g.jitter);
  }
}

}  // namespace

int validate(int argc, char** argv) {
  const bool is_long = long_run_requested(argc, argv);
  Report report("Two disks in the plane, exact potential on the walls (D 6.37)");

  const auto cut_cell = [](int cells) {
    return std::make_unique<laplace::CutCellSolver>(laplace::CutCellOptions{.cells = cells});
  };
  report.section("cut-cell, errors in %");
  convergence(report, cut_cell, is_long ? std::vector<double>{4, 8, 16, 32, 64} : std::vector<double>{4, 8, 16},
              is_long ? 20 : 12, true, 1.7);
  report.section("cut-cell, jitter");
  jitter(report);

  const auto relaxation = [](int sites) {
    return std::make_unique<laplace::RelaxationSolver>(laplace::RelaxationOptions{.sites = sites});
  };
  report.section("relaxation, errors in % (first order: the staircase)");
  convergence(report, relaxation, is_long ? std::vector<double>{4, 8, 16, 32} : std::vector<double>{4, 8, 16}, 8, false,
              0.7);
  return report.exit_status();
}

const lichtenberg::validation::Program program("two_disks", validate);

}  // namespace two_disks_validation
