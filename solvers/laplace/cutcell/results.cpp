#include "solvers/laplace/cutcell/results.hpp"

#include <map>

namespace lichtenberg::laplace {

namespace {

/// Above this conductance (cells) the difference of the two potentials is mostly rounding, and the link's flux is
/// taken from the balance of its cell instead: what comes in through the other faces.
constexpr double short_link = 1e6;

/// Potential differences across the short links, by index of the link.
std::map<std::size_t, double> short_link_differences(const LaplaceProblem& problem, const Level& level,
                                                     const double* cell, double scale,
                                                     const LaplaceSolution& solution) {
  std::map<std::size_t, double> difference;
  for (std::size_t m = 0; m < level.links.size(); ++m) {
    const Link& shortest = level.links[m];
    if (shortest.conductance < short_link) continue;
    const std::ptrdiff_t slot = shortest.cell;
    const double v = scale * cell[slot];
    const std::ptrdiff_t in_colour = slot % level.layout.colour_size();
    const int colour = slot >= level.layout.colour_size();
    const int j = static_cast<int>(in_colour / level.layout.stride) - 1;
    const std::ptrdiff_t k = slot - level.layout.row(colour, j);
    const int parity = Layout::parity(colour, j);
    double inflow = 0;
    for (const std::ptrdiff_t neighbour :
         {level.layout.row(1 - colour, j) + k + parity - 1, level.layout.row(1 - colour, j) + k + parity,
          level.layout.row(1 - colour, j - 1) + k, level.layout.row(1 - colour, j + 1) + k})
      if (level.diagonal[neighbour] > 0) inflow += scale * cell[neighbour] - v;
    bool only_one = true;
    for (std::size_t n = 0; n < level.links.size(); ++n) {
      const Link& link = level.links[n];
      if (n == m || link.cell != slot) continue;
      only_one = only_one && link.conductance < short_link;
      inflow += link.conductance * (solution.group_potential[problem.bodies[link.body].group] - v);
    }
    for (const SideLink& link : level.side_links)
      if (link.cell == slot) inflow += link.conductance * (link.potential - v);
    if (only_one) difference[m] = -inflow / shortest.conductance;
  }
  return difference;
}

}  // namespace

void evaluate(const LaplaceProblem& problem, const Level& level, const double* cell, double scale,
              LaplaceSolution& solution) {
  const double eps = problem.permittivity;
  const double stress = 0.5 * eps / level.h;
  solution.body_charge.assign(problem.bodies.size(), 0.0);
  solution.body_force.assign(problem.bodies.size(), Vec2{});
  solution.side_charge.fill(0.0);
  const auto potential = [&](int body) { return solution.group_potential[problem.bodies[body].group]; };

  const std::map<std::size_t, double> short_links = short_link_differences(problem, level, cell, scale, solution);
  for (std::size_t m = 0; m < level.links.size(); ++m) {
    const Link& link = level.links[m];
    double difference = potential(link.body) - scale * cell[link.cell];
    if (link.conductance >= short_link)
      if (const auto found = short_links.find(m); found != short_links.end()) difference = found->second;
    solution.body_charge[link.body] += eps * link.conductance * difference;
    solution.body_force[link.body] += (stress * difference * difference) * link.gradient;
  }
  for (const CrossGradient& cross : level.cross_gradients) {
    const Link& link = level.links[cross.link];
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
