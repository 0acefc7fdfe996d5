#include "solvers/laplace/measure.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lichtenberg::laplace {
namespace {

constexpr double least_share = 1e-3;

bool is_disk(const Body& body) { return std::holds_alternative<Disk>(body.shape); }

double potential_range(const LaplaceProblem& problem, const LaplaceSolution& solution) {
  double low = INFINITY, high = -INFINITY;
  const auto include = [&](double potential) {
    low = std::min(low, potential);
    high = std::max(high, potential);
  };
  for (const double potential : solution.group_potential) include(potential);
  for (const Side& side : problem.sides) {
    if (side.kind != Side::Kind::electrode) continue;
    for (const double x : {0.0, problem.size.x})
      for (const double y : {0.0, problem.size.y}) include(side.potential_at({x, y}));
  }
  // Potentials are sums of some tens of terms; differences of some roundings of them are none.
  constexpr double rounding = 100 * std::numeric_limits<double>::epsilon();
  return high - low > rounding * std::max(std::abs(high), std::abs(low)) ? high - low : 0;
}

}  // namespace

Scales scales_of(const LaplaceProblem& problem, const LaplaceSolution& solution) {
  Scales scales;
  scales.potential = potential_range(problem, solution);
  const double unit = least_share * problem.permittivity * scales.potential;
  scales.charge = unit;
  scales.force = unit * scales.potential / std::max(problem.size.x, problem.size.y);
  for (std::size_t b = 0; b < problem.bodies.size(); ++b) {
    scales.charge = std::max(scales.charge, std::abs(solution.body_charge[b]));
    if (is_disk(problem.bodies[b])) scales.force = std::max(scales.force, norm(solution.body_force[b]));
  }
  return scales;
}

double largest_error(const LaplaceProblem& problem, const LaplaceSolution& solution, const LaplaceSolution& reference,
                     const Scales& scales) {
  if (scales.potential == 0) return 0;  // nothing but rounding
  double worst = 0;
  for (std::size_t g = 0; g < problem.groups.size(); ++g)
    worst = std::max(worst, std::abs(solution.group_potential[g] - reference.group_potential[g]) / scales.potential);
  for (std::size_t b = 0; b < problem.bodies.size(); ++b) {
    worst = std::max(worst, std::abs(solution.body_charge[b] - reference.body_charge[b]) / scales.charge);
    if (is_disk(problem.bodies[b]))
      worst = std::max(worst, norm(solution.body_force[b] - reference.body_force[b]) / scales.force);
  }
  return worst;
}

}  // namespace lichtenberg::laplace
