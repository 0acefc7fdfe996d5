#include "solvers/laplace/cutcell/results.hpp"

#include <algorithm>

#include "solvers/geometry/closed_curve.hpp"
#include "solvers/laplace/cutcell/slabs.hpp"

namespace lichtenberg::laplace {

namespace {

/// Computes the torques on closed curves about their centroids, by virtual work as the forces. `potential(body)`,
/// `fluid(link)`: potentials of a body and of a link's fluid cell (V).
template <class Potential, class Fluid>
void add_torques(const LaplaceProblem& problem, const Level& level, const Potential& potential, const Fluid& fluid,
                 LaplaceSolution& solution) {
  solution.body_torque.assign(problem.bodies.size(), 0.0);
  std::vector<Vec2> pivot(problem.bodies.size());
  for (std::size_t body = 0; body < problem.bodies.size(); ++body)
    if (const auto* freeform = std::get_if<Freeform>(&problem.bodies[body].shape))
      pivot[body] = freeform->curve->centroid();
  const auto add = [&](int body, double difference, Vec2 arm, Vec2 gradient) {
    if (!std::holds_alternative<Freeform>(problem.bodies[body].shape)) return;
    const double stress = 0.5 * problem.permittivity * difference * difference / level.h;
    solution.body_torque[body] += stress * cross(level.h * arm - pivot[body], gradient);
  };
  const auto across = [&](const FluidLink& link) { return potential(link.body) - fluid(link); };
  for (const LinkArm& arm : level.arms) {
    const FluidLink& link = level.links[arm.link];
    add(link.body, across(link), arm.at, link.gradient);
  }
  for (const CrossGradient& each : level.cross_gradients)
    add(each.body, across(level.links[each.link]), each.arm, each.gradient);
  for (const PairLink& pair : level.pairs) {
    const double difference = potential(pair.body_a) - potential(pair.body_b);
    add(pair.body_a, difference, pair.arm_a, pair.gradient_a);
    add(pair.body_b, difference, pair.arm_b, pair.gradient_b);
  }
  for (const SideLink& link : level.side_links)
    if (link.body >= 0) add(link.body, link.potential - potential(link.body), link.arm, link.gradient);
}

}  // namespace

void evaluate(const LaplaceProblem& problem, const Level& level, const double* cell, double scale,
              LaplaceSolution& solution, parallel::Team& team) {
  const double eps = problem.permittivity;
  const double stress = 0.5 * eps / level.h;
  const Layout& at = level.layout;
  solution.body_charge.assign(problem.bodies.size(), 0.0);
  solution.body_force.assign(problem.bodies.size(), Vec2{});
  solution.side_charge.fill(0.0);
  const auto potential = [&](int body) { return solution.group_potential[problem.bodies[body].group]; };

  const int bodies = static_cast<int>(problem.bodies.size());
  const int chunks = std::clamp(static_cast<int>(level.links.size()) / 1024, 1, 4 * team.size());
  team.for_each(chunks, [&](int chunk) {
    for (int body = bodies * chunk / chunks; body < bodies * (chunk + 1) / chunks; ++body)
      for (int m = level.link_start[body]; m < level.link_start[body + 1]; ++m) {
        const FluidLink& link = level.links[m];
        if (!at.owns(link.cell)) continue;
        const double difference = potential(body) - scale * cell[link.cell];
        solution.body_charge[body] += eps * link.conductance * difference;
        solution.body_force[body] += (stress * difference * difference) * link.gradient;
      }
  });
  for (const CrossGradient& cross : level.cross_gradients) {
    const FluidLink& link = level.links[cross.link];
    if (!at.owns(link.cell)) continue;
    const double difference = potential(link.body) - scale * cell[link.cell];
    solution.body_force[cross.body] += (stress * difference * difference) * cross.gradient;
  }
  for (const PairLink& pair : level.pairs) {
    if (!at.is_first()) break;
    const double difference = potential(pair.body_a) - potential(pair.body_b);
    const double flux = eps * pair.conductance * difference;
    solution.body_charge[pair.body_a] += flux;
    solution.body_charge[pair.body_b] -= flux;
    solution.body_force[pair.body_a] += (stress * difference * difference) * pair.gradient_a;
    solution.body_force[pair.body_b] += (stress * difference * difference) * pair.gradient_b;
  }
  solution.body_torque.clear();
  if (!level.arms.empty())
    add_torques(
        problem, level, potential, [&](const FluidLink& link) { return scale * cell[link.cell]; }, solution);
  double energy = 0;
  for (const SideLink& link : level.side_links) {
    if (link.cell >= 0 && !at.owns(link.cell)) continue;
    const double difference = link.potential - (link.cell >= 0 ? scale * cell[link.cell] : potential(link.body));
    const double flux = eps * link.conductance * difference;
    solution.side_charge[link.side] += flux;
    energy += 0.5 * flux * link.potential;
    if (link.body < 0) continue;
    solution.body_charge[link.body] -= flux;
    solution.body_force[link.body] += (stress * difference * difference) * link.gradient;
  }
  add_over_slabs(at, solution.body_charge.data(), std::ssize(solution.body_charge));
  add_over_slabs(at, &solution.body_force.data()->x, 2 * std::ssize(solution.body_force));
  add_over_slabs(at, solution.side_charge.data(), std::ssize(solution.side_charge));
  energy = sum_over_slabs(at, energy);
  for (std::size_t body = 0; body < problem.bodies.size(); ++body)
    energy += 0.5 * solution.body_charge[body] * potential(static_cast<int>(body));
  solution.energy = energy;
}

}  // namespace lichtenberg::laplace
