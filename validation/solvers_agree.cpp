// Compares the cut-cell solver with the dissertation's relaxation, an independent method. On the same scene, with
// groups and electrodes of every shape, potentials, charges and forces must converge to each other as h -> 0, at the
// first order of the staircase.
//
//   solvers_agree         S = 64, 128, 256
//   solvers_agree long    S = 64 ... 1024

#include <random>

#include "solvers/laplace/cutcell/solver.hpp"
#include "solvers/laplace/relaxation/solver.hpp"
#include "validation/harness.hpp"
#include "validation/program.hpp"

namespace solvers_agree_validation {

using namespace lichtenberg;
using namespace lichtenberg::laplace;
using namespace lichtenberg::validation;

namespace {

/// Adds `count` disks of radius 0.04 to 0.06 with charges in [-1, 1] inside the unit box, at least 0.05 apart, each as
/// a group of its own.
void add_floating_disks(LaplaceProblem& problem, int count, std::uint64_t seed) {
  constexpr double least_gap = 0.05;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> fraction(0, 1);
  while (count > 0) {
    const double radius = 0.04 + 0.02 * fraction(random);
    const Disk disk{{fraction(random), fraction(random)}, radius};
    const double to_wall = std::min({disk.centre.x, disk.centre.y, 1 - disk.centre.x, 1 - disk.centre.y}) - radius;
    const bool free = std::all_of(problem.bodies.begin(), problem.bodies.end(),
                                  [&](const Body& body) { return gap(disk, body.shape) > least_gap; });
    if (!free || to_wall < least_gap) continue;
    problem.bodies.push_back({disk, static_cast<int>(problem.groups.size())});
    problem.groups.push_back({.charge = 2 * fraction(random) - 1});
    --count;
  }
}

LaplaceProblem unit_box() {
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {1, 1};
  return problem;
}

LaplaceProblem grounded_side() {
  LaplaceProblem problem = unit_box();
  problem.sides[bottom].kind = Side::Kind::electrode;
  add_floating_disks(problem, 12, 1);
  return problem;
}

/// Returns a scene with a grounded half-disk on an insulating wall.
LaplaceProblem half_disk() {
  LaplaceProblem problem = unit_box();
  problem.bodies = {{Disk{{0.5, 0}, 0.15}, 0}};
  problem.groups = {{.floating = false, .potential = 0}};
  add_floating_disks(problem, 10, 2);
  return problem;
}

/// Returns a scene inside a grounded rim; two disks form one group.
LaplaceProblem dish() {
  LaplaceProblem problem = unit_box();
  problem.bodies = {{Ring{{0.5, 0.5}, 0.47}, 0}};
  problem.groups = {{.floating = false, .potential = 0}};
  add_floating_disks(problem, 9, 3);
  problem.bodies.back().group -= 1;
  problem.groups.pop_back();
  return problem;
}

/// Returns uncharged disks between two bars at a potential difference, one of them oblique. Forces on bars have no
/// bound: the field is singular at their corners, and virtual work on links that end there has errors of tens of
/// percent.
LaplaceProblem bars() {
  LaplaceProblem problem = unit_box();
  problem.bodies = {{Bar{{0.15, 0.2}, {0.15, 0.8}, 0.1}, 0}, {Bar{{0.8, 0.25}, {0.9, 0.75}, 0.1}, 1}};
  problem.groups = {{.floating = false, .potential = 0.5}, {.floating = false, .potential = -0.5}};
  add_floating_disks(problem, 8, 4);
  for (Group& group : problem.groups) group.charge = 0;
  return problem;
}

/// Returns an insulated, neutral scene.
LaplaceProblem ungrounded() {
  LaplaceProblem problem = unit_box();
  add_floating_disks(problem, 8, 5);
  double total = 0;
  for (const Group& group : problem.groups) total += group.charge;
  for (Group& group : problem.groups) group.charge -= total / 8;
  return problem;
}

struct Difference {
  Spread potential, charge;  ///< per body, percent of the largest
  Spread disk_force;         ///< per disk, percent of the largest force on a body
  double bar_force = 0;      ///< worst of the bars, in the same unit
};
Difference difference(const LaplaceProblem& problem, int cells) {
  const LaplaceSolution a = CutCellSolver({.cells = cells}).solve(problem);
  const LaplaceSolution b = RelaxationSolver({.sites = cells}).solve(problem);
  double potential = 0, charge = 0, force = 0;
  for (std::size_t k = 0; k < problem.bodies.size(); ++k) {
    potential = std::max(potential, std::abs(a.group_potential[problem.bodies[k].group]));
    charge = std::max(charge, std::abs(a.body_charge[k]));
    force = std::max(force, norm(a.body_force[k]));
  }
  std::vector<double> potentials, charges, forces;
  double bar_force = 0;
  for (std::size_t k = 0; k < problem.bodies.size(); ++k) {
    const int group = problem.bodies[k].group;
    potentials.push_back(100 * (b.group_potential[group] - a.group_potential[group]) / potential);
    charges.push_back(100 * (b.body_charge[k] - a.body_charge[k]) / charge);
    const double force_difference = 100 * norm(b.body_force[k] - a.body_force[k]) / force;
    if (std::holds_alternative<Bar>(problem.bodies[k].shape))
      bar_force = std::max(bar_force, force_difference);
    else
      forces.push_back(force_difference);
  }
  return {spread(potentials), spread(charges), spread(forces), bar_force};
}

/// At S = 256, a disk has a radius of 10 to 15 cells and a gap of 13 cells to the next. The staircase displaces its
/// surface by half a cell at most: 4 % of the gap and of a potential difference across it, twice that of a force.
constexpr double potential_bound = 4, force_bound = 8;

void compare(Report& report, const std::string& name, const LaplaceProblem& problem, const std::vector<double>& sizes) {
  std::vector<double> potential, force;
  for (const double cells : sizes) {
    const Difference d = difference(problem, static_cast<int>(cells));
    const auto at_256 = [&](double bound) { return cells == 256 ? std::optional(bound) : std::nullopt; };
    const std::string label = fmt::format("{}, S = {:<4}", name, cells);
    report.at_most(label + " potentials", d.potential, at_256(potential_bound));
    report.at_most(label + " charges", d.charge, at_256(potential_bound));
    report.at_most(label + " forces on disks", d.disk_force, at_256(force_bound));
    if (d.bar_force > 0) report.at_most(label + " forces on bars (corners)", d.bar_force, {});
    potential.push_back(d.potential.mean);
    force.push_back(d.disk_force.mean);
  }
  report.at_least(name + ", order of the potentials", order(sizes, potential), 0.7);
  report.at_least(name + ", order of the forces", order(sizes, force), 0.7);
}

}  // namespace

int validate(int argc, char** argv) {
  const std::vector<double> sizes =
      long_run_requested(argc, argv) ? std::vector<double>{64, 128, 256, 512, 1024} : std::vector<double>{64, 128, 256};
  Report report("Cut-cell against relaxation");
  report.section("differences in % of the largest value");
  compare(report, "grounded side", grounded_side(), sizes);
  compare(report, "half-disk on a wall", half_disk(), sizes);
  compare(report, "dish, with a group of two", dish(), sizes);
  compare(report, "two bars", bars(), sizes);
  compare(report, "no ground", ungrounded(), sizes);
  return report.exit_status();
}

const lichtenberg::validation::Program program("solvers_agree", validate);

}  // namespace solvers_agree_validation
