#include "solvers/laplace/cutcell/results.hpp"

#include <algorithm>
#include <map>

namespace lichtenberg::laplace {

namespace {

/// What flows into a fluid cell through its four faces with other fluid cells.
double inflow_from_fluid(const Level& level, const double* cell, double scale, std::ptrdiff_t slot) {
  const Layout& at = level.layout;
  const int colour = slot >= at.colour_size();
  const int j = static_cast<int>(slot % at.colour_size() / at.stride) - 1;
  const std::ptrdiff_t k = slot - at.row(colour, j), beside = at.row(1 - colour, j) + k + Layout::parity(colour, j);
  double inflow = 0;
  const std::ptrdiff_t below = at.row(1 - colour, j - 1) + k, above = at.row(1 - colour, j + 1) + k;
  for (const std::ptrdiff_t neighbour : {beside - 1, beside, below, above})
    if (level.diagonal[neighbour] > 0) inflow += scale * cell[neighbour] - scale * cell[slot];
  return inflow;
}

/// Potential differences across the short links, by index of the link; of a cell with two of them, none.
std::map<std::size_t, double> short_link_differences(const LaplaceProblem& problem, const Level& level,
                                                     const double* cell, double scale,
                                                     const LaplaceSolution& solution) {
  struct Balance {
    std::size_t link = 0;  // the short one
    int short_links = 0;
    double inflow = 0;  // through all others
  };
  std::map<std::ptrdiff_t, Balance> balances;  // of the cells with short links
  for (std::size_t m = 0; m < level.links.size(); ++m) {
    if (level.links[m].conductance < short_link) continue;
    const std::ptrdiff_t slot = level.links[m].cell;
    const auto [balance, is_new] = balances.try_emplace(slot);
    if (is_new) balance->second.inflow = inflow_from_fluid(level, cell, scale, slot);
    balance->second.link = m;
    ++balance->second.short_links;
  }
  if (balances.empty()) return {};
  const auto flow_in = [&](std::ptrdiff_t slot, double conductance, double potential) {
    const auto balance = balances.find(slot);
    if (balance != balances.end()) balance->second.inflow += conductance * (potential - scale * cell[slot]);
  };
  for (const Link& link : level.links)
    if (link.conductance < short_link)
      flow_in(link.cell, link.conductance, solution.group_potential[problem.bodies[link.body].group]);
  for (const SideLink& link : level.side_links) flow_in(link.cell, link.conductance, link.potential);

  std::map<std::size_t, double> difference;
  for (const auto& [slot, balance] : balances)
    if (balance.short_links == 1) difference[balance.link] = -balance.inflow / level.links[balance.link].conductance;
  return difference;
}

}  // namespace

void evaluate(const LaplaceProblem& problem, const Level& level, const double* cell, double scale,
              LaplaceSolution& solution, Team& team) {
  const double eps = problem.permittivity;
  const double stress = 0.5 * eps / level.h;
  solution.body_charge.assign(problem.bodies.size(), 0.0);
  solution.body_force.assign(problem.bodies.size(), Vec2{});
  solution.side_charge.fill(0.0);
  const auto potential = [&](int body) { return solution.group_potential[problem.bodies[body].group]; };

  const std::map<std::size_t, double> short_links = short_link_differences(problem, level, cell, scale, solution);
  const int bodies = static_cast<int>(problem.bodies.size());
  const int chunks = std::clamp(static_cast<int>(level.links.size()) / 1024, 1, 4 * team.size());
  team.for_each(chunks, [&](int chunk) {
    for (int body = bodies * chunk / chunks; body < bodies * (chunk + 1) / chunks; ++body)
      for (int m = level.link_start[body]; m < level.link_start[body + 1]; ++m) {
        const Link& link = level.links[m];
        double difference = potential(body) - scale * cell[link.cell];
        if (link.conductance >= short_link)
          if (const auto found = short_links.find(m); found != short_links.end()) difference = found->second;
        solution.body_charge[body] += eps * link.conductance * difference;
        solution.body_force[body] += (stress * difference * difference) * link.gradient;
      }
  });
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
