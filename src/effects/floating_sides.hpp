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

/// Returns the charge of a group: its bodies, its sides, and the charge that its couplings carry to other groups.
inline double charge_of(const FloatingSides& floating, const laplace::LaplaceProblem& problem,
                        const laplace::LaplaceSolution& solution) {
  double charge = 0;
  for (const int side : floating.sides) charge += solution.side_charge[side];
  for (std::size_t b = 0; b < problem.bodies.size(); ++b)
    if (problem.bodies[b].group == floating.group) charge += solution.body_charge[b];
  const std::vector<double> flowed = laplace::coupling_charges(problem, solution);
  for (std::size_t k = 0; k < flowed.size(); ++k)
    charge += flowed[k] * ((problem.couplings[k].a == floating.group) - (problem.couplings[k].b == floating.group));
  return charge;
}
inline double charge_of(const FloatingSides& floating, const laplace::SphereProblem& problem,
                        const laplace::SphereSolution& solution) {
  double charge = 0;
  for (const int side : floating.sides) charge += solution.side_charge[side];
  for (std::size_t i = 0; i < problem.spheres.size(); ++i)
    if (problem.spheres[i].group == floating.group) charge += solution.sphere_charge[i];
  const std::vector<double>& flowed = solution.coupling_charge;
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
/// solution. `problem` then has the sides' potentials, and their groups are fixed at them. Throws the exceptions of
/// `solver`.
template <class Problem, class Solver>
auto solve_with_floating_sides(Problem& problem, const std::vector<FloatingSides>& floating, Solver& solver) {
  const std::size_t n = floating.size();
  std::vector<double> missing, matrix(n * n);
  const auto set = [](Problem& one, const FloatingSides& sides, double potential) {
    one.groups[sides.group] = {.floating = false, .potential = potential};
    for (const int side : sides.sides) set_side(one, side, potential);
  };
  for (const FloatingSides& sides : floating) missing.push_back(problem.groups[sides.group].charge);
  for (const FloatingSides& sides : floating) set(problem, sides, 0);
  Problem unit = problem;
  for (laplace::Group& group : unit.groups) group.charge = group.potential = 0;
  for (int side = 0; side < count_sides(unit); ++side) set_side(unit, side, 0);
  for (std::size_t k = 0; k < n; ++k) {
    set(unit, floating[k], 1);
    const auto solution = solver.solve(unit);
    for (std::size_t i = 0; i < n; ++i) matrix[i * n + k] = charge_of(floating[i], unit, solution);
    set(unit, floating[k], 0);
  }
  const auto at_zero = solver.solve(problem);
  for (std::size_t i = 0; i < n; ++i) missing[i] -= charge_of(floating[i], problem, at_zero);
  const std::vector<double> potential = solved(std::move(matrix), std::move(missing));
  for (std::size_t k = 0; k < n; ++k) set(problem, floating[k], potential[k]);
  return solver.solve(problem);
}

}  // namespace lichtenberg::effects
