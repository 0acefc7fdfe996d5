#include "solvers/laplace/measure.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "solvers/larger.hpp"

namespace lichtenberg::laplace {
namespace {

double potential_range(const LaplaceProblem& problem, const LaplaceSolution& solution) {
  std::vector<double> potentials = solution.group_potential;
  for (const Side& side : problem.sides) {
    if (side.kind != Side::Kind::electrode) continue;
    for (const double x : {0.0, problem.size.x})
      for (const double y : {0.0, problem.size.y}) potentials.push_back(side.potential_at({x, y}));
  }
  return largest_difference(potentials);
}

/// Returns the difference over the largest value; nan if the difference is nan.
double error_of(double difference, double largest, double rounding) {
  return difference <= rounding ? 0 : difference / std::max(largest, rounding);
}

}  // namespace

bool has_force(const LaplaceProblem& problem, std::size_t body) {
  return (problem.movable < 0 || static_cast<int>(body) < problem.movable) &&
         std::holds_alternative<Disk>(problem.bodies[body].shape);
}

double largest_difference(const std::vector<double>& potentials) {
  if (potentials.empty()) return 0;
  if (!std::ranges::all_of(potentials, [](double v) { return std::isfinite(v); })) return NAN;
  const auto [low, high] = std::ranges::minmax(potentials);
  // Potentials are sums of some tens of terms; differences at the level of their rounding count as zero.
  constexpr double rounding = 100 * std::numeric_limits<double>::epsilon();
  return high - low > rounding * std::max(std::abs(high), std::abs(low)) ? high - low : 0;
}

double Scales::error_of_charge(double difference) const { return error_of(difference, charge, charge_rounding); }
double Scales::error_of_force(double difference) const { return error_of(difference, force, force_rounding); }

SmallValues small_values(const LaplaceProblem& problem, const Scales& scales) {
  const double charge = small_share * problem.permittivity * scales.potential;
  return {charge, charge * scales.potential / std::max(problem.size.x, problem.size.y)};
}

Scales scales_of(const LaplaceProblem& problem, const LaplaceSolution& solution) {
  Scales scales;
  scales.potential = potential_range(problem, solution);
  const auto [charge, force] = small_values(problem, scales);
  scales.charge_rounding = share_of_rounding / small_share * charge;
  scales.force_rounding = share_of_rounding / small_share * force;
  bool any_force = false;
  for (std::size_t b = 0; b < problem.bodies.size(); ++b) {
    scales.charge = std::max(scales.charge, std::abs(solution.body_charge[b]));
    if (!has_force(problem, b)) continue;
    scales.force = std::max(scales.force, norm(solution.body_force[b]));
    any_force = true;
  }
  if (!any_force) scales.force = INFINITY;
  return scales;
}

double largest_error(const LaplaceProblem& problem, const LaplaceSolution& solution, const LaplaceSolution& reference,
                     const Scales& scales) {
  if (scales.potential == 0) return 0;  // All potentials are equal to rounding
  double worst = 0;
  for (std::size_t g = 0; g < problem.groups.size(); ++g)
    worst = larger(worst, std::abs(solution.group_potential[g] - reference.group_potential[g]) / scales.potential);
  for (std::size_t b = 0; b < problem.bodies.size(); ++b) {
    worst = larger(worst, scales.error_of_charge(std::abs(solution.body_charge[b] - reference.body_charge[b])));
    if (has_force(problem, b))
      worst = larger(worst, scales.error_of_force(norm(solution.body_force[b] - reference.body_force[b])));
  }
  return worst;
}

}  // namespace lichtenberg::laplace
