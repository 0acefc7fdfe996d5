// Compares the cut-cell solver's closed-form forces with central differences of its energy at fixed charges (virtual
// work): F = -dG/dx with G = W - sum of potential times charge over bodies of given potential.
//
//   energy_force         S = 128, 10 disks
//   energy_force long    S = 512, 60 disks

#include <random>

#include "solvers/laplace/cutcell/solver.hpp"
#include "validation/harness.hpp"
#include "validation/program.hpp"

namespace energy_force_validation {

using namespace lichtenberg;
using namespace lichtenberg::laplace;
using namespace lichtenberg::validation;

namespace {

/// Returns disks with radii of 6 to 9 cells in a box of `cells`, some only `least_gap` cells apart, two in one group; a
/// half-disk at 0.3 V on an insulating wall; the upper side at -0.2 V. Lengths in cells.
LaplaceProblem scene(int cells, int disks, double least_gap) {
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {1.0 * cells, 1.0 * cells};
  problem.sides[top] = {.kind = Side::Kind::electrode, .potential = -0.2, .profile = {}};
  problem.bodies = {{Disk{{0.5 * cells + 0.3, 0}, 14}, 0}};
  problem.groups = {{.floating = false, .potential = 0.3}};
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> fraction(0, 1);
  const auto add_disk = [&](Disk disk) {
    const double to_wall =
        std::min({disk.centre.x, disk.centre.y, cells - disk.centre.x, cells - disk.centre.y}) - disk.radius;
    const bool free = std::all_of(problem.bodies.begin(), problem.bodies.end(),
                                  [&](const Body& body) { return gap(disk, body.shape) > 0.99 * least_gap; });
    if (!free || to_wall < 3) return false;
    problem.bodies.push_back({disk, static_cast<int>(problem.groups.size())});
    problem.groups.push_back({.charge = 2 * fraction(random) - 1});
    return true;
  };
  while (static_cast<int>(problem.bodies.size()) <= disks) {
    const Disk first{{cells * fraction(random), cells * fraction(random)}, 6 + 3 * fraction(random)};
    if (!add_disk(first)) continue;
    const double angle = 6.28 * fraction(random), radius = 6 + 3 * fraction(random);
    add_disk({first.centre + (first.radius + radius + least_gap) * Vec2{std::cos(angle), std::sin(angle)}, radius});
  }
  problem.bodies.back().group -= 1;
  problem.groups.pop_back();
  return problem;
}

/// Returns G. At fixed charges and given potentials, the force is minus its gradient.
double free_energy(const LaplaceProblem& problem, const LaplaceSolution& solution) {
  double result = solution.energy;
  for (std::size_t b = 0; b < problem.bodies.size(); ++b)
    if (const Group& group = problem.groups[problem.bodies[b].group]; !group.floating)
      result -= group.potential * solution.body_charge[b];
  for (int side = 0; side < 4; ++side) result -= problem.sides[side].potential * solution.side_charge[side];
  return result;
}

/// Returns the smallest distance of a cell centre from the circle of a disk, in cells.
double nearest_centre(const Disk& disk) {
  const auto first = [&](double centre) { return static_cast<int>(std::floor(centre - disk.radius)) - 1; };
  const int across = static_cast<int>(2 * disk.radius) + 4;
  double nearest = 1;
  for (int j = first(disk.centre.y); j < first(disk.centre.y) + across; ++j)
    for (int i = first(disk.centre.x); i < first(disk.centre.x) + across; ++i)
      nearest = std::min(nearest, std::abs(norm(Vec2{i + 0.5, j + 0.5} - disk.centre) - disk.radius));
  return nearest;
}

double displaced(CutCellSolver& solver, LaplaceProblem problem, std::size_t body, Vec2 by) {
  std::get<Disk>(problem.bodies[body].shape).centre += by;
  return free_energy(problem, solver.solve(problem));
}

/// Returns -dG along `direction`. A link whose cell centre has the distance d from the surface has a conductance that
/// is at most as steep as 1/d. A central difference with the step 0.01 d has a relative error of 1e-4 of its force. The
/// link has a few per cent of the whole force. Rounding errors of the energy permit steps from 1e-6 on; empty for
/// others.
std::optional<double> difference_quotient(CutCellSolver& solver, const LaplaceProblem& problem, std::size_t body,
                                          Vec2 direction) {
  const double step = std::min(1e-4, 0.01 * nearest_centre(std::get<Disk>(problem.bodies[body].shape)));
  if (step < 1e-6) return {};
  return -(displaced(solver, problem, body, step * direction) - displaced(solver, problem, body, -step * direction)) /
         (2 * step);
}

void compare(Report& report, int cells, int disks, double least_gap) {
  const LaplaceProblem problem = scene(cells, disks, least_gap);
  CutCellSolver solver({.cells = cells, .tolerance = 1e-11});
  const LaplaceSolution solution = solver.solve(problem);
  double largest = 0;
  for (const Vec2 force : solution.body_force) largest = std::max(largest, norm(force));

  std::vector<double> error;
  for (std::size_t body = 1; body < problem.bodies.size(); ++body)
    for (const Vec2 direction : {Vec2{1, 0}, Vec2{0, 1}})
      if (const auto force = difference_quotient(solver, problem, body, direction))
        error.push_back((*force - dot(solution.body_force[body], direction)) / largest);
  // If a gap contains no fluid cell, the conductance is an integral over the channel by quadrature. Force and
  // difference then agree within the quadrature error, 1e-3.
  const double bound = least_gap >= 1 ? 1e-4 : 2e-3;
  report.at_most(fmt::format("smallest gap {} cells, {} components", least_gap, error.size()), spread(error), bound);
}

}  // namespace

int validate(int argc, char** argv) {
  const bool is_long = long_run_requested(argc, argv);
  const int cells = is_long ? 512 : 128, disks = is_long ? 60 : 10;
  Report report("Forces against differences of the energy");
  report.section("error as a fraction of the largest force");
  for (const double least_gap : {4.0, 1.0, 0.3, 0.05}) compare(report, cells, disks, least_gap);
  return report.exit_status();
}

const lichtenberg::validation::Program program("energy_force", validate);

}  // namespace energy_force_validation
