#include "solvers/laplace/circuit_nodes.hpp"

#include <algorithm>

namespace lichtenberg::laplace {

CircuitNodes::CircuitNodes(const LaplaceProblem& problem) {
  if (problem.couplings.empty()) return;
  const std::size_t groups = problem.groups.size();
  is_kept_.assign(groups, 0);
  for (const Body& body : problem.bodies) is_kept_[body.group] = 1;
  for (std::size_t g = 0; g < groups; ++g) is_kept_[g] = is_kept_[g] || !problem.groups[g].floating;
  any_ = std::find(is_kept_.begin(), is_kept_.end(), 0) != is_kept_.end();
  if (!any_) return;

  std::vector<NetworkLink> links;
  for (const auto& [a, b, capacitance] : problem.couplings) links.push_back({a, b, capacitance});
  factors_ = NetworkFactors(std::vector<double>(groups, 0.0), links, is_kept_);
  flow_.assign(groups, 0.0);
  for (std::size_t g = 0; g < groups; ++g)
    if (!is_kept_[g]) flow_[g] = problem.groups[g].charge;
  factors_.eliminate(flow_.data());

  reduced_ = problem;
  for (std::size_t g = 0; g < groups; ++g) {
    if (is_kept_[g])
      reduced_.groups[g].charge += flow_[g];
    else
      reduced_.groups[g] = {.floating = false};
  }
  reduced_.couplings.clear();
  for (const auto& [a, b, capacitance] : factors_.kept_links()) reduced_.couplings.push_back({a, b, capacitance});
}

void CircuitNodes::set_potentials(std::vector<double>& potential) const {
  for (std::size_t g = 0; g < potential.size(); ++g)
    if (!is_kept_[g]) potential[g] = flow_[g];
  factors_.substitute(potential.data());
}

}  // namespace lichtenberg::laplace
