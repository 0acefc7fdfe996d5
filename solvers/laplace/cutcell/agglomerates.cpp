#include "solvers/laplace/cutcell/agglomerates.hpp"

namespace lichtenberg::laplace {

Agglomerates find_agglomerates(const LaplaceProblem& problem, const std::vector<NetworkLink>& direct_links) {
  constexpr double least = 0.05;
  const int groups = static_cast<int>(problem.groups.size());
  std::vector<Coupling> couplings = problem.couplings;
  for (const auto& [a, b, conductance] : direct_links)
    if (conductance > least_joining) couplings.push_back({a, b, conductance * problem.permittivity});
  Agglomerates agglomerates{coupled_sets(groups, couplings, least * problem.permittivity),
                            std::vector<char>(groups, 0)};
  const auto mark_grounded = [&](int group) { agglomerates.is_grounded[agglomerates.first_group[group]] = 1; };
  for (int g = 0; g < groups; ++g)
    if (!problem.groups[g].floating) mark_grounded(g);
  if (problem.has_fixed_conductor()) return agglomerates;
  for (const Coupling& coupling : problem.couplings) {
    if (coupling.capacitance == 0) continue;
    if (!problem.groups[coupling.a].floating) mark_grounded(coupling.b);
    if (!problem.groups[coupling.b].floating) mark_grounded(coupling.a);
  }
  return agglomerates;
}

}  // namespace lichtenberg::laplace
