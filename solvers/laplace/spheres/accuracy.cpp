#include "solvers/laplace/spheres/accuracy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "solvers/error.hpp"
#include "solvers/larger.hpp"

namespace lichtenberg::laplace {
namespace {

double longest_side(const SphereProblem& problem) {
  if (!problem.free_space) return std::max({problem.box.lengths.x, problem.box.lengths.y, problem.box.lengths.z});
  Vec3 low{INFINITY, INFINITY, INFINITY}, high = low * -1.0;
  for (const Sphere& sphere : problem.spheres)
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], sphere.centre[k] - sphere.radius);
      high[k] = std::max(high[k], sphere.centre[k] + sphere.radius);
    }
  return std::max({high.x - low.x, high.y - low.y, high.z - low.z});
}

int movable(const SphereProblem& problem) {
  return problem.movable < 0 ? static_cast<int>(problem.spheres.size()) : problem.movable;
}

constexpr double finest_tolerance = 1e-12;

/// Bound on the errors of charges and forces at a tolerance of 1, in units of the largest. The potential scale V makes
/// charges of 4 pi eps R V on a sphere, and fields of V / R at its charge and V / R^2 at its dipole.
double sensitivity(const SphereProblem& problem, const SphereSolution& solution, const Scales& scales) {
  std::vector<int> members(problem.groups.size());
  for (const Sphere& sphere : problem.spheres) ++members[sphere.group];
  double charge = 0, force = 0;
  for (std::size_t i = 0; i < problem.spheres.size(); ++i) {
    const auto& [centre, radius, group, permittivity] = problem.spheres[i];
    const bool is_given = problem.groups[group].floating && members[group] == 1;
    if (!is_given) charge = std::max(charge, 4 * std::numbers::pi * problem.permittivity * radius * scales.potential);
    if (static_cast<int>(i) < movable(problem))
      force = std::max(force, (std::abs(solution.sphere_charge[i]) + norm(solution.sphere_dipole[i]) / radius) *
                                  scales.potential / radius);
  }
  return std::max(charge / std::max(scales.charge, scales.charge_rounding),
                  force / std::max(scales.force, scales.force_rounding));
}

/// Upper bound of actual errors, as a share of the sensitivity.
constexpr double likely_share = 1e-3;

/// Solves to `finer` times the accuracy or better. Returns nothing if the method refuses the harmonics.
std::optional<SphereSolution> finer_solution(const SphereProblem& problem, double accuracy, double coarser,
                                             double finer, const std::function<SphereSolver(double)>& solver_for) {
  constexpr double most_finer = 1e-3;
  double tolerance = std::max(finer * coarser, finest_tolerance);
  try {
    for (;;) {
      SphereSolution solution = solver_for(tolerance).solve(problem);
      const Scales scales = scales_of(problem, solution);
      if (tolerance == finest_tolerance || scales.potential == 0) return solution;
      const double needed = finer * accuracy / (likely_share * sensitivity(problem, solution, scales));
      if (tolerance <= needed) return solution;
      tolerance = std::max({needed, most_finer * tolerance, finest_tolerance});
    }
  } catch (const InputError&) {
  } catch (const Failure&) {
  }
  return std::nullopt;
}

/// Returns the reference for a solution at the tolerance `coarser`: ten times as accurate as `accuracy`, or at least
/// twice if the method refuses more. Throws InputError if it refuses that, too.
SphereSolution reference_for(const SphereProblem& problem, double accuracy, double coarser,
                             const std::function<SphereSolver(double)>& solver_for) {
  for (const double finer : {0.1, 0.3, 0.5})
    if (std::optional<SphereSolution> found = finer_solution(problem, accuracy, coarser, finer, solver_for))
      return *std::move(found);
  throw InputError(
      fmt::format("field.accuracy = {:g} cannot be checked: spheres refuse a finer solution to compare with here; "
                  "field.tolerance in place of field.accuracy solves without a check",
                  accuracy));
}

[[noreturn]] void refuse(double accuracy, double possible) {
  throw InputError(
      fmt::format("field.accuracy = {:g} cannot be met: rounding ends the digits of spheres here, and "
                  "about {:.1e} would be possible",
                  accuracy, possible));
}

}  // namespace

namespace {

/// Returns the largest potential difference (V) between groups, electrodes and infinity. In a uniform field, potentials
/// are measured from the field's own potential at the sphere, and the field's difference over all spheres also counts.
double potential_scale(const SphereProblem& problem, const SphereSolution& solution) {
  std::vector<double> potentials = solution.group_potential;
  const double uniform = problem.free_space ? norm(problem.uniform_field) : 0;
  if (uniform > 0) {
    potentials.clear();
    for (const Sphere& sphere : problem.spheres)
      potentials.push_back(solution.group_potential[sphere.group] + dot(problem.uniform_field, sphere.centre));
  }
  if (problem.free_space) potentials.push_back(0);
  for (int side = 0; side < 6 && !problem.free_space; ++side)
    if (problem.box.sides[side] == Boundary::electrode) potentials.push_back(problem.side_potential[side]);
  const double difference = largest_difference(potentials);
  return uniform > 0 ? std::max(difference, uniform * longest_side(problem)) : difference;
}

}  // namespace

Scales scales_of(const SphereProblem& problem, const SphereSolution& solution) {
  Scales scales;
  scales.potential = potential_scale(problem, solution);
  const double unit = share_of_rounding * problem.permittivity * scales.potential;
  scales.charge_rounding = unit * longest_side(problem);
  scales.force_rounding = unit * scales.potential;
  for (const double charge : solution.sphere_charge) scales.charge = std::max(scales.charge, std::abs(charge));
  for (int i = 0; i < movable(problem); ++i) scales.force = std::max(scales.force, norm(solution.sphere_force[i]));
  if (movable(problem) == 0) scales.force = INFINITY;
  return scales;
}

double largest_error(const SphereProblem& problem, const SphereSolution& solution, const SphereSolution& reference,
                     const Scales& scales) {
  if (scales.potential == 0) return 0;
  double worst = 0;
  for (std::size_t g = 0; g < reference.group_potential.size(); ++g)
    worst = larger(worst, std::abs(solution.group_potential[g] - reference.group_potential[g]) / scales.potential);
  for (std::size_t i = 0; i < reference.sphere_charge.size(); ++i) {
    worst = larger(worst, scales.error_of_charge(std::abs(solution.sphere_charge[i] - reference.sphere_charge[i])));
    if (static_cast<int>(i) < movable(problem))
      worst = larger(worst, scales.error_of_force(norm(solution.sphere_force[i] - reference.sphere_force[i])));
  }
  return worst;
}

AccurateSpheres solve_to_accuracy(const SphereProblem& problem, double accuracy,
                                  const std::function<SphereSolver(double)>& solver_for) {
  constexpr double margin = 0.8, least_finer = 0.5, most_finer = 1e-2;
  // With the few harmonics of a coarser tolerance, the difference of two solutions does not measure their errors.
  constexpr double coarsest = 1e-2;
  for (double tolerance = std::min(accuracy, coarsest);;) {
    AccurateSpheres found{tolerance, accuracy, solver_for(tolerance), {}};
    double finer = least_finer;
    try {
      found.solution = found.solver.solve(problem);
      const SphereSolution reference = reference_for(problem, accuracy, tolerance, solver_for);
      found.estimate = largest_error(problem, found.solution, reference, scales_of(problem, reference));
      if (found.estimate <= margin * accuracy) return found;
      if (tolerance == finest_tolerance) refuse(accuracy, found.estimate);
      finer = std::clamp(margin * accuracy / found.estimate, most_finer, least_finer);
    } catch (const Failure&) {  // The truncation at a coarse tolerance can make the matrix indefinite
      if (tolerance == finest_tolerance) throw;
    }
    tolerance = std::max(finer * tolerance, finest_tolerance);
  }
}

}  // namespace lichtenberg::laplace
