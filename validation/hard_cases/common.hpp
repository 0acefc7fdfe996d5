#pragma once

// Common functions of the hard cases: scenes, comparison of solutions, and origin of the bounds.

#include <initializer_list>
#include <numbers>
#include <random>

#include "solvers/laplace/cutcell/solver.hpp"
#include "solvers/laplace/multipole/solver.hpp"
#include "validation/harness.hpp"

namespace lichtenberg::validation {

using namespace laplace;
using std::numbers::pi;

/// Errors of potentials and forces, in percent of the scene's largest potential and force.
struct Quality {
  double potential, force;
};

/// Returns the expected error of the cut-cell method for a disk radius and a narrowest gap, both in cells. For gap / R
/// >= 0.1 it follows from the bounds of the validation program `two_disks` at R = 8, scaled as h^2. In narrower gaps,
/// of a cell or less, the single conductance across the gap determines the error. The bounds are 7.9 % of the
/// capacitance and 9.9 % of the force.
inline Quality expected(double radius, double gap) {
  const double h2 = (8 / radius) * (8 / radius);
  if (gap >= 2 * radius) return {0.02 * h2, 0.1 * h2};
  if (gap >= 0.5 * radius) return {0.15 * h2, 0.6 * h2};
  if (gap >= 0.1 * radius) return {1 * h2, 3.5 * h2};
  return {7.9, 9.9};
}

/// Bound on conjugate gradient iterations for gaps from 0.01 cell and up to 5000 conductors on 128 to 4096 cells;
/// smaller grids need no more. Harder cases may need twice as many.
constexpr double most_iterations = 12;

/// Returns the wall time of a solve (ms).
inline double milliseconds(const LaplaceSolution& solution) {
  return 1e3 * (solution.seconds.setup + solution.seconds.solve + solution.seconds.forces);
}

/// Formats the cost of a solve, such as "12 iterations, 3.4 ms".
inline std::string cost(const LaplaceSolution& solution) {
  return fmt::format("{} iterations, {:.3g} ms", solution.iterations, milliseconds(solution));
}

/// Formats the largest number of iterations of several solves.
inline std::string most_of(int iterations) { return fmt::format("{} iterations at most", iterations); }

/// Makes an empty problem in a box with cells of edge 1; the listed sides are electrodes at 0 V, the others insulating.
inline LaplaceProblem box(Vec2 size, std::initializer_list<SideIndex> grounded) {
  LaplaceProblem problem{.permittivity = 1};
  problem.size = size;
  for (const SideIndex side : grounded) problem.sides[side].kind = Side::Kind::electrode;
  return problem;
}
/// Makes an empty problem in a box whose four sides are electrodes at 0 V.
inline LaplaceProblem grounded_box(Vec2 size) { return box(size, {left, right, bottom, top}); }

/// Adds a disk to a problem, as a group of its own with the given charge or potential.
inline void add(LaplaceProblem& problem, Disk disk, Group group) {
  problem.bodies.push_back({disk, static_cast<int>(problem.groups.size())});
  problem.groups.push_back(group);
}

/// Adds columns x rows disks with random charges in [-1, 1], evenly spaced over the box and randomly displaced by up to
/// `jitter` in x and y.
inline void add_lattice(LaplaceProblem& problem, int columns, int rows, double radius, double jitter,
                        std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const Vec2 site{(i + 0.5) * problem.size.x / columns, (j + 0.5) * problem.size.y / rows};
      const Vec2 shift = jitter * Vec2{uniform(random), uniform(random)};
      add(problem, {site + shift, radius}, {.charge = uniform(random)});
    }
}

/// Returns the shape of a body that is a disk.
inline const Disk& disk_of(const LaplaceProblem& problem, int body) {
  return std::get<Disk>(problem.bodies[body].shape);
}

/// Solves a problem by the cut-cell method with cells of edge 1.
inline LaplaceSolution cut_cell(const LaplaceProblem& problem) {
  return CutCellSolver({.cells = static_cast<int>(std::max(problem.size.x, problem.size.y))}).solve(problem);
}
/// Solves a problem by the multipole method, as a reference.
inline LaplaceSolution spectral(const LaplaceProblem& problem, double tolerance = 1e-8) {
  return MultipoleSolver({.tolerance = tolerance}).solve(problem);
}

/// Returns the largest magnitude of a potential (V) of the groups and electrode sides.
inline double largest_potential(const LaplaceProblem& problem, const LaplaceSolution& solution) {
  double largest = 0;
  for (const double phi : solution.group_potential) largest = std::max(largest, std::abs(phi));
  for (const Side& side : problem.sides)
    if (side.kind == Side::Kind::electrode) largest = std::max(largest, std::abs(side.potential));
  return largest;
}

/// Computes the errors of the groups' potentials relative to a reference solution, in percent of the largest potential.
inline Spread potential_error(const LaplaceProblem& problem, const LaplaceSolution& solution,
                              const LaplaceSolution& exact) {
  std::vector<double> error;
  for (std::size_t g = 0; g < problem.groups.size(); ++g)
    error.push_back(100 * (solution.group_potential[g] - exact.group_potential[g]));
  const double largest = largest_potential(problem, exact);
  for (double& e : error) e /= largest;
  return spread(error);
}

/// Computes the errors of the forces relative to a reference solution, in percent of the largest force.
inline Spread force_error(const LaplaceSolution& solution, const LaplaceSolution& exact) {
  double largest = 0;
  for (const Vec2 force : exact.body_force) largest = std::max(largest, norm(force));
  std::vector<double> error;
  for (std::size_t b = 0; b < exact.body_force.size(); ++b)
    error.push_back(100 * norm(solution.body_force[b] - exact.body_force[b]) / largest);
  return spread(error);
}

/// Computes the error of the charge balance: the largest deviation of a floating group's charge from its given value,
/// or of the total charge from zero. It is relative to the sum of the charges' magnitudes, which is at least the charge
/// of the largest potential on a capacitance eps per body.
inline double charge_imbalance(const LaplaceProblem& problem, const LaplaceSolution& solution) {
  double total = 0, magnitudes = 0, worst = 0;
  std::vector<double> group(problem.groups.size(), 0.0);
  for (std::size_t b = 0; b < problem.bodies.size(); ++b) group[problem.bodies[b].group] += solution.body_charge[b];
  const auto count = [&](double charge) {
    total += charge;
    magnitudes += std::abs(charge);
  };
  for (const double charge : group) count(charge);
  for (const double charge : solution.side_charge) count(charge);
  for (std::size_t g = 0; g < group.size(); ++g)
    if (problem.groups[g].floating) worst = std::max(worst, std::abs(group[g] - problem.groups[g].charge));
  const double bodies = static_cast<double>(problem.bodies.size());
  magnitudes = std::max(magnitudes, bodies * problem.permittivity * largest_potential(problem, solution));
  return magnitudes > 0 ? std::max(worst, std::abs(total)) / magnitudes : 0.0;
}

/// Compares the cut-cell method with the multipole method for a problem, and adds rows to the report: potentials,
/// forces, charge balance and iterations, with their bounds.
inline void compare(Report& report, const std::string& name, const LaplaceProblem& problem, Quality bound,
                    double iterations = most_iterations) {
  const LaplaceSolution exact = spectral(problem), solution = cut_cell(problem);
  report.at_most(name + ": potentials, %", potential_error(problem, solution, exact), bound.potential, cost(solution));
  report.at_most(name + ": forces, %", force_error(solution, exact), bound.force);
  report.at_most(name + ": charge balance", charge_imbalance(problem, solution), 1e-10);
  report.at_most(name + ": iterations", solution.iterations, iterations);
}

}  // namespace lichtenberg::validation
