#include "solvers/laplace/cutcell/results.hpp"

#include <algorithm>

namespace lichtenberg::laplace {

void take_results(const LaplaceProblem& problem, const BodyResult* result, double side_energy,
                  LaplaceSolution& solution) {
  const std::size_t bodies = problem.bodies.size();
  solution.body_charge.resize(bodies);
  solution.body_force.resize(bodies);
  solution.energy = side_energy;
  for (std::size_t body = 0; body < bodies; ++body) {
    solution.body_charge[body] = result[body].charge;
    solution.body_force[body] = {result[body].force_x, result[body].force_y};
    solution.energy += 0.5 * result[body].charge * solution.group_potential[problem.bodies[body].group];
  }
}

void evaluate(const LaplaceProblem& problem, const Level& level, const double* cell, double scale,
              LaplaceSolution& solution, parallel::Team& team) {
  const LinkResults of(problem.permittivity, level.h);
  const int bodies = static_cast<int>(problem.bodies.size());
  std::vector<BodyResult> result(bodies);
  const auto potential = [&](int body) { return solution.group_potential[problem.bodies[body].group]; };
  const int chunks = std::clamp(static_cast<int>(level.links.size()) / 1024, 1, 4 * team.size());
  team.for_each(chunks, [&](int chunk) {
    for (int body = bodies * chunk / chunks; body < bodies * (chunk + 1) / chunks; ++body)
      for (int m = level.link_start[body]; m < level.link_start[body + 1]; ++m) {
        const FluidLink& link = level.links[m];
        result[body] += of.link(link.conductance, potential(body) - scale * cell[link.cell], link.gradient);
      }
  });
  for (const CrossGradient& cross : level.cross_gradients) {
    const FluidLink& link = level.links[cross.link];
    result[cross.body] += of.force(potential(link.body) - scale * cell[link.cell], cross.gradient);
  }
  for (const PairLink& pair : level.pairs) {
    const double difference = potential(pair.body_a) - potential(pair.body_b);
    result[pair.body_a] += of.link(pair.conductance, difference, pair.gradient_a);
    result[pair.body_b] += of.link(pair.conductance, -difference, pair.gradient_b);
  }
  solution.side_charge.fill(0.0);
  double energy = 0;
  for (const SideLink& link : level.side_links) {
    const double difference = link.potential - (link.cell >= 0 ? scale * cell[link.cell] : potential(link.body));
    const double flux = of.flux(link.conductance, difference);
    solution.side_charge[link.side] += flux;
    energy += 0.5 * flux * link.potential;
    if (link.body >= 0) result[link.body] += of.link(link.conductance, -difference, link.gradient);
  }
  take_results(problem, result.data(), energy, solution);
}

}  // namespace lichtenberg::laplace
