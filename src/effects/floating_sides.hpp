#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include "solvers/error.hpp"
#include "solvers/laplace/circuit.hpp"
#include "solvers/laplace/problem.hpp"
#include "solvers/laplace/spheres/spheres.hpp"
#include "src/effects/electrostatics.hpp"

namespace lichtenberg::effects {

inline void set_side(laplace::LaplaceProblem& problem, int side, double potential) {
  problem.sides[side].potential = potential;
}
inline void set_side(laplace::SphereProblem& problem, int side, double potential) {
  problem.side_potential[side] = potential;
}
inline int count_sides(const laplace::LaplaceProblem& problem) { return static_cast<int>(problem.sides.size()); }
inline int count_sides(const laplace::SphereProblem& problem) {
  return static_cast<int>(problem.side_potential.size());
}

/// Returns the charges through the couplings of a solved problem, as laplace::coupling_charges() does in the plane.
inline std::vector<double> coupling_charges(const laplace::SphereProblem& problem,
                                            const laplace::SphereSolution& solution) {
  laplace::LaplaceProblem circuit{.permittivity = problem.permittivity * problem.box.lengths.x,
                                  .groups = problem.groups,
                                  .couplings = problem.couplings};
  for (const laplace::Sphere& sphere : problem.spheres) circuit.bodies.push_back({{}, sphere.group});
  return laplace::coupling_charges(
      circuit, {.group_potential = solution.group_potential, .body_charge = solution.sphere_charge});
}

/// Returns the charge on the sides of a group.
inline double charge_of_sides(const FloatingSides& floating, const auto& solution) {
  double charge = 0;
  for (const int side : floating.sides) charge += solution.side_charge[side];
  return charge;
}

/// Returns the charge of each body.
inline const std::vector<double>& body_charges(const laplace::LaplaceSolution& solution) {
  return solution.body_charge;
}
inline const std::vector<double>& body_charges(const laplace::SphereSolution& solution) {
  return solution.sphere_charge;
}
inline int group_of_body(const laplace::LaplaceProblem& problem, std::size_t b) { return problem.bodies[b].group; }
inline int group_of_body(const laplace::SphereProblem& problem, std::size_t b) { return problem.spheres[b].group; }

/// Returns the charge of a group at a fixed potential: its bodies, its sides, and the charge that its couplings carry
/// to other groups.
inline double charge_of(const FloatingSides& floating, const auto& problem, const auto& solution) {
  double charge = charge_of_sides(floating, solution);
  for (std::size_t b = 0; b < body_charges(solution).size(); ++b)
    if (group_of_body(problem, b) == floating.group) charge += body_charges(solution)[b];
  const std::vector<double> flowed = coupling_charges(problem, solution);
  for (std::size_t k = 0; k < flowed.size(); ++k)
    charge += flowed[k] * ((problem.couplings[k].a == floating.group) - (problem.couplings[k].b == floating.group));
  return charge;
}

/// Solves a * x = b by Gauss's elimination with pivots for a few unknowns; `a` is row-major [n * n]. Throws Failure for
/// a singular matrix.
inline std::vector<double> solved(std::vector<double> a, std::vector<double> b) {
  const std::size_t n = b.size();
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k + 1; i < n; ++i)
      if (std::abs(a[i * n + k]) > std::abs(a[pivot * n + k])) pivot = i;
    if (a[pivot * n + k] == 0) throw Failure("the potentials of the sides in circuits are undetermined");
    for (std::size_t j = 0; j < n; ++j) std::swap(a[k * n + j], a[pivot * n + j]);
    std::swap(b[k], b[pivot]);
    for (std::size_t i = 0; i < n; ++i) {
      if (i == k) continue;
      const double factor = a[i * n + k] / a[k * n + k];
      for (std::size_t j = k; j < n; ++j) a[i * n + j] -= factor * a[k * n + j];
      b[i] -= factor * b[k];
    }
  }
  for (std::size_t k = 0; k < n; ++k) b[k] /= a[k * n + k];
  return b;
}

/// Solves a field problem in which the potentials of sides float. Solvers take given potentials of sides only. Charges
/// are linear in potentials (D 6.20): two solves for each group with sides determine its potential. In one of them this
/// potential is 0. In the other it is 1 V, and all other given charges and potentials are 0. A last solve has the
/// solution. `problem` then has the sides' potentials, and their groups have the charge without the sides', so that
/// coupling_charges() gives the charges through couplings. Throws the exceptions of `solver`.
template <class Problem, class Solver>
auto solve_with_floating_sides(Problem& problem, std::vector<FloatingSides> floating, Solver& solver) {
  const auto set = [](Problem& one, const FloatingSides& sides, double potential) {
    one.groups[sides.group] = {.floating = false, .potential = potential};
    for (const int side : sides.sides) set_side(one, side, potential);
  };
  // A group that a contact connects with a source has its potential.
  std::erase_if(floating, [&](const FloatingSides& sides) {
    const laplace::Group& group = problem.groups[sides.group];
    if (!group.floating) set(problem, sides, group.potential);
    return !group.floating;
  });
  const std::size_t n = floating.size();
  std::vector<double> given, matrix(n * n);
  int iterations = 0;
  for (const FloatingSides& sides : floating) given.push_back(problem.groups[sides.group].charge);
  for (const FloatingSides& sides : floating) set(problem, sides, 0);
  Problem unit = problem;
  for (laplace::Group& group : unit.groups) group.charge = group.potential = 0;
  for (int side = 0; side < count_sides(unit); ++side) set_side(unit, side, 0);
  for (std::size_t k = 0; k < n; ++k) {
    set(unit, floating[k], 1);
    const auto solution = solver.solve(unit);
    iterations += solution.iterations;
    for (std::size_t i = 0; i < n; ++i) matrix[i * n + k] = charge_of(floating[i], unit, solution);
    set(unit, floating[k], 0);
  }
  if (n == 0) return solver.solve(problem);
  const auto at_zero = solver.solve(problem);
  std::vector<double> missing = given;
  for (std::size_t i = 0; i < n; ++i) missing[i] -= charge_of(floating[i], problem, at_zero);
  const std::vector<double> potential = solved(std::move(matrix), std::move(missing));
  for (std::size_t k = 0; k < n; ++k) set(problem, floating[k], potential[k]);
  auto solution = solver.solve(problem);
  solution.iterations += iterations + at_zero.iterations;
  // As in floating groups, couplings carry the rest of the charge: exact for couplings of any size.
  for (std::size_t k = 0; k < n; ++k)
    problem.groups[floating[k].group] = {.charge = given[k] - charge_of_sides(floating[k], solution)};
  return solution;
}

}  // namespace lichtenberg::effects
