#include "solvers/laplace/cutcell/sets.hpp"

namespace lichtenberg::laplace {

Sets strongly_coupled(const LaplaceProblem& problem, const std::vector<NetworkLink>& direct_links) {
  constexpr double least = 0.05;
  const int groups = static_cast<int>(problem.groups.size());
  std::vector<Coupling> couplings = problem.couplings;
  for (const auto& [a, b, conductance] : direct_links)
    if (conductance > least_joining) couplings.push_back({a, b, conductance * problem.permittivity});
  Sets sets{coupled_sets(groups, couplings, least * problem.permittivity), std::vector<char>(groups, 0)};
  const auto hold = [&](int group) { sets.is_held[sets.of_group[group]] = 1; };
  for (int g = 0; g < groups; ++g)
    if (!problem.groups[g].floating) hold(g);
  if (problem.has_fixed_conductor()) return sets;
  for (const Coupling& coupling : problem.couplings) {
    if (coupling.capacitance == 0) continue;
    if (!problem.groups[coupling.a].floating) hold(coupling.b);
    if (!problem.groups[coupling.b].floating) hold(coupling.a);
  }
  return sets;
}

}  // namespace lichtenberg::laplace
