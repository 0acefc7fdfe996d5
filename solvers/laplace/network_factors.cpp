#include "solvers/laplace/network_factors.hpp"

#include <algorithm>
#include <set>

namespace lichtenberg::laplace {

namespace {

/// Links of a node as pairs (other node, conductance), sorted by node.
using Neighbours = std::vector<std::pair<int, double>>;

void add(Neighbours& neighbours, int node, double conductance) {
  const auto at = std::lower_bound(neighbours.begin(), neighbours.end(), node,
                                   [](const auto& link, int other) { return link.first < other; });
  if (at != neighbours.end() && at->first == node)
    at->second += conductance;
  else
    neighbours.insert(at, {node, conductance});
}

void remove(Neighbours& neighbours, int node) {
  std::erase_if(neighbours, [node](const auto& link) { return link.first == node; });
}

}  // namespace

NetworkFactors::NetworkFactors(std::vector<double> ground, const std::vector<NetworkLink>& links,
                               const std::vector<char>& keep) {
  const int nodes = static_cast<int>(ground.size());
  std::vector<Neighbours> neighbours(nodes);
  for (const auto& [a, b, conductance] : links) {
    if (conductance == 0) continue;
    add(neighbours[a], b, conductance);
    add(neighbours[b], a, conductance);
  }
  // Elimination by least degree: trees are eliminated from their leaves without fill-in.
  std::set<std::pair<std::size_t, int>> order;
  const auto is_kept = [&](int node) { return !keep.empty() && keep[node]; };
  const auto enter = [&](int node) {
    if (!is_kept(node)) order.insert({neighbours[node].size(), node});
  };
  for (int node = 0; node < nodes; ++node) enter(node);
  while (!order.empty()) {
    const int node = order.begin()->second;
    order.erase(order.begin());
    const Neighbours star = std::move(neighbours[node]);
    double pivot = ground[node];
    for (const auto& [other, conductance] : star) pivot += conductance;
    steps_.push_back({node, pivot, shares_.size()});
    for (const auto& [other, conductance] : star) {
      const double share = conductance / pivot;
      shares_.push_back({other, share});
      ground[other] += share * ground[node];
      if (!is_kept(other)) order.erase({neighbours[other].size(), other});
      remove(neighbours[other], node);
      for (const auto& [third, to_third] : star)
        if (third != other) add(neighbours[other], third, conductance * to_third / pivot);
    }
    for (const auto& [other, conductance] : star) enter(other);
  }
  for (int node = 0; node < nodes; ++node)
    for (const auto& [other, conductance] : neighbours[node])
      if (node < other) kept_.push_back({node, other, conductance});
}

void NetworkFactors::eliminate(double* flow) const {
  for (std::size_t s = 0; s < steps_.size(); ++s) {
    const std::size_t end = s + 1 < steps_.size() ? steps_[s + 1].first_share : shares_.size();
    for (std::size_t k = steps_[s].first_share; k < end; ++k)
      flow[shares_[k].node] += shares_[k].fraction * flow[steps_[s].node];
  }
}

void NetworkFactors::substitute(double* potential) const {
  for (std::size_t s = steps_.size(); s-- > 0;) {
    const auto& [node, pivot, first_share] = steps_[s];
    const std::size_t end = s + 1 < steps_.size() ? steps_[s + 1].first_share : shares_.size();
    potential[node] = pivot > 0 ? potential[node] / pivot : 0.0;
    for (std::size_t k = first_share; k < end; ++k) potential[node] += shares_[k].fraction * potential[shares_[k].node];
  }
}

void NetworkFactors::solve(double* flow) const {
  eliminate(flow);
  substitute(flow);
}

std::vector<double> NetworkFactors::inverse() const {
  const std::size_t n = steps_.size();
  std::vector<double> matrix(n * n, 0.0);
  const auto row = [&](int node) { return matrix.data() + node * n; };
  const auto add = [&](int to, double share, int from) {
    double* __restrict sum = row(to);
    const double* __restrict term = row(from);
    for (std::size_t k = 0; k < n; ++k) sum[k] += share * term[k];
  };
  for (std::size_t k = 0; k < n; ++k) matrix[k * n + k] = 1;
  const auto end_of = [&](std::size_t s) { return s + 1 < n ? steps_[s + 1].first_share : shares_.size(); };
  for (std::size_t s = 0; s < n; ++s)
    for (std::size_t k = steps_[s].first_share; k < end_of(s); ++k)
      add(shares_[k].node, shares_[k].fraction, steps_[s].node);
  for (std::size_t s = n; s-- > 0;) {
    const auto& [node, pivot, first_share] = steps_[s];
    for (std::size_t k = 0; k < n; ++k) row(node)[k] = pivot > 0 ? row(node)[k] / pivot : 0.0;
    for (std::size_t k = first_share; k < end_of(s); ++k) add(node, shares_[k].fraction, shares_[k].node);
  }
  return matrix;
}

std::vector<NetworkLink> NetworkFactors::kept_links() const { return kept_; }

}  // namespace lichtenberg::laplace
