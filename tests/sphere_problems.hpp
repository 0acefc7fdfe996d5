#pragma once

#include "solvers/laplace/spheres/spheres.hpp"

/// Problems for the solver of spheres.
namespace lichtenberg::sphere_problems {

using namespace laplace;

/// Box with electrodes at the bottom and the top, periodic along x, and insulating along y.
inline SphereProblem mixed_box() {
  SphereProblem problem{.permittivity = 2};
  problem.box.lengths = {1.0, 0.9, 1.1};
  problem.box.sides = {Boundary::periodic, Boundary::periodic,  Boundary::wall,
                       Boundary::wall,     Boundary::electrode, Boundary::electrode};
  problem.side_potential[4] = 1, problem.side_potential[5] = -0.5;
  problem.spheres = {{{0.1, 0.3, 0.4}, 0.15, 0}, {{0.5, 0.6, 0.7}, 0.2, 1}, {{0.9, 0.35, 0.75}, 0.12, 2}};
  problem.groups = {{.charge = 1}, {.floating = false, .potential = 0.3}, {.charge = -0.7}};
  return problem;
}

/// Potential of the forces at given charges and given potentials: the energy minus that supplied at given potentials.
inline double free_energy(const SphereProblem& problem, const SphereSolution& solution) {
  double energy = solution.energy;
  for (std::size_t i = 0; i < problem.spheres.size(); ++i) {
    const Group& group = problem.groups[problem.spheres[i].group];
    if (!group.floating) energy -= solution.sphere_charge[i] * group.potential;
  }
  for (int side = 0; side < 6; ++side) energy -= solution.side_charge[side] * problem.side_potential[side];
  return energy;
}

/// Dielectric and conducting spheres with narrow gaps in a box that is periodic in all directions.
inline SphereProblem periodic_mixture() {
  SphereProblem problem{.permittivity = 1};
  problem.box.lengths = {1.0, 0.9, 1.1};
  problem.box.sides.fill(Boundary::periodic);
  problem.spheres = {{{0.1, 0.3, 0.4}, 0.15, 0, 4.0}, {{0.41, 0.43, 0.56}, 0.2, 1}, {{0.9, 0.2, 0.55}, 0.12, 2, 30.0}};
  problem.groups = {{.charge = 1}, {.charge = -0.3}, {.charge = -0.7}};
  return problem;
}

/// Force plus the derivative of the energy, which vanishes. `degree` is SphereOptions::degree.
inline double slope_error(const SphereProblem& problem, int sphere, int axis, double step, double accuracy,
                          int degree = 0) {
  SphereSolver solver({.accuracy = accuracy, .degree = degree});
  const double force = solver.solve(problem).sphere_force[sphere][axis];
  const auto at_distance = [&](double distance) {
    SphereProblem moved = problem;
    moved.spheres[sphere].centre[axis] += distance;
    return free_energy(moved, solver.solve(moved));
  };
  const double slope =
      (8 * (at_distance(step) - at_distance(-step)) - (at_distance(2 * step) - at_distance(-2 * step))) / (12 * step);
  return force + slope;
}

}  // namespace lichtenberg::sphere_problems
