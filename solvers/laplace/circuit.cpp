#include "solvers/laplace/circuit.hpp"

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

/// Computes capacitance * (V_a - V_b) first, then distributes the residuals of the balances through the same network.
/// Each group has the conductance eps to ground in it, about its capacitance in the field, so that rounding errors flow
/// to ground and not through weak couplings.
std::vector<double> coupling_charges(const LaplaceProblem& problem, const LaplaceSolution& solution) {
  if (problem.couplings.empty()) return {};
  std::vector<double> flowed;
  std::vector<NetworkLink> links;
  std::vector<double> ground(problem.groups.size());
  for (std::size_t g = 0; g < ground.size(); ++g) ground[g] = problem.groups[g].floating ? problem.permittivity : 0.0;
  for (const auto& [a, b, capacitance] : problem.couplings) {
    flowed.push_back(capacitance * (solution.group_potential[a] - solution.group_potential[b]));
    if (problem.groups[a].floating && problem.groups[b].floating)
      links.push_back({a, b, capacitance});
    else if (problem.groups[a].floating || problem.groups[b].floating)
      ground[problem.groups[a].floating ? a : b] += capacitance;
  }
  const NetworkFactors factors(std::move(ground), links);
  constexpr int passes = 4;  // Each pass leaves at most 1e-16 of the charges, times capacitance / eps
  for (int pass = 0; pass < passes && !flowed.empty(); ++pass) {
    std::vector<double> left(problem.groups.size());
    for (std::size_t g = 0; g < left.size(); ++g) left[g] = problem.groups[g].charge;
    for (std::size_t b = 0; b < problem.bodies.size(); ++b) left[problem.bodies[b].group] -= solution.body_charge[b];
    for (std::size_t k = 0; k < flowed.size(); ++k) {
      left[problem.couplings[k].a] -= flowed[k];
      left[problem.couplings[k].b] += flowed[k];
    }
    for (std::size_t g = 0; g < left.size(); ++g)
      if (!problem.groups[g].floating) left[g] = 0;
    factors.solve(left.data());
    for (std::size_t k = 0; k < flowed.size(); ++k) {
      const auto& [a, b, capacitance] = problem.couplings[k];
      flowed[k] += capacitance * (left[a] - left[b]);
    }
  }
  return flowed;
}

}  // namespace lichtenberg::laplace
