#include "solvers/laplace/cutcell/results.hpp"

#include <algorithm>

namespace lichtenberg::laplace {

void evaluate(const LaplaceProblem& problem, const Level& level, const double* cell, double scale,
              LaplaceSolution& solution, parallel::Team& team) {
  const double eps = problem.permittivity;
  const double stress = 0.5 * eps / level.h;
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
        const double difference = potential(body) - scale * cell[link.cell];
        solution.body_charge[body] += eps * link.conductance * difference;
        solution.body_force[body] += (stress * difference * difference) * link.gradient;
      }
  });
  for (const CrossGradient& cross : level.cross_gradients) {
    const FluidLink& link = level.links[cross.link];
    const double difference = potential(link.body) - scale * cell[link.cell];
    solution.body_force[cross.body] += (stress * difference * difference) * cross.gradient;
  }
  for (const PairLink& pair : level.pairs) {
    const double difference = potential(pair.body_a) - potential(pair.body_b);
    const double flux = eps * pair.conductance * difference;
    solution.body_charge[pair.body_a] += flux;
    solution.body_charge[pair.body_b] -= flux;
    solution.body_force[pair.body_a] += (stress * difference * difference) * pair.gradient_a;
    solution.body_force[pair.body_b] += (stress * difference * difference) * pair.gradient_b;
  }
  double energy = 0;
  for (const SideLink& link : level.side_links) {
    const double difference = link.potential - (link.cell >= 0 ? scale * cell[link.cell] : potential(link.body));
    const double flux = eps * link.conductance * difference;
    solution.side_charge[link.side] += flux;
    energy += 0.5 * flux * link.potential;
    if (link.body < 0) continue;
    solution.body_charge[link.body] -= flux;
    solution.body_force[link.body] += (stress * difference * difference) * link.gradient;
  }
  for (std::size_t body = 0; body < problem.bodies.size(); ++body)
    energy += 0.5 * solution.body_charge[body] * potential(static_cast<int>(body));
  solution.energy = energy;
}

}  // namespace lichtenberg::laplace
