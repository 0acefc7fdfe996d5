#include "solvers/network/subnetwork.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "solvers/network/spatial_order.hpp"
#include "solvers/parallel/ranges.hpp"

namespace lichtenberg::network {
namespace {

/// Returns the nodes in their new order: `first`, then the others by position, or in the order of the links.
std::vector<int> order_of(const Network& network, const std::vector<int>& first, parallel::Team& team) {
  std::vector<int> order = first;
  order.reserve(network.nodes);
  std::vector<char> taken(network.nodes, 0);
  const auto take = [&](int n) {
    if (std::exchange(taken[n], 1) == 0) order.push_back(n);
  };
  for (const int n : first) taken[n] = 1;
  if (!network.position.empty()) {
    for (const int n : spatial_order(network.position, team)) take(n);
    return order;
  }
  for (const Link& link : network.links) take(link.a), take(link.b);
  for (int n = 0; n < network.nodes; ++n) take(n);
  return order;
}

/// Renumbers the links and sorts them by their smaller node. Each task sorts the links of some nodes, so that the order
/// does not depend on the number of tasks.
void sort_links(const Network& network, const std::vector<int>& number, parallel::Team& team, Subnetwork& result) {
  const std::size_t links = network.links.size();
  result.network.links.resize(links);
  result.link.resize(links);
  std::vector<std::pair<int, int>> ends(links);
  parallel::for_each_range(links, team, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) ends[k] = {number[network.links[k].a], number[network.links[k].b]};
  });
  const auto for_each_link = [&](const auto& act) {
    const int tasks = team.size();
    team.for_each(tasks, [&](int task) {
      const auto bound = [&](int t) { return static_cast<int>(std::int64_t(network.nodes) * t / tasks); };
      for (std::size_t k = 0; k < links; ++k)
        if (const int n = std::min(ends[k].first, ends[k].second); n >= bound(task) && n < bound(task + 1)) act(n, k);
    });
  };
  std::vector<int> start(network.nodes + 1, 0);
  for_each_link([&](int n, std::size_t) { ++start[n + 1]; });
  std::partial_sum(start.begin(), start.end(), start.begin());
  for_each_link([&](int n, std::size_t k) {
    const int at = start[n]++;
    result.network.links[at] = {ends[k].first, ends[k].second, network.links[k].conductance};
    result.link[at] = static_cast<int>(k);
  });
}

}  // namespace

Subnetwork reordered(const Network& network, const std::vector<int>& first, parallel::Team& team) {
  Subnetwork result{.network = {.nodes = network.nodes}, .node = order_of(network, first, team)};
  std::vector<int> number(network.nodes);
  const bool placed = !network.position.empty();
  result.network.position.resize(placed ? network.nodes : 0);
  parallel::for_each_range(network.nodes, team, [&](int begin, int end) {
    for (int n = begin; n < end; ++n) {
      number[result.node[n]] = n;
      if (placed) result.network.position[n] = network.position[result.node[n]];
    }
  });
  sort_links(network, number, team, result);
  return result;
}

void keep_links(Subnetwork& part, std::span<const char> chosen, int kept) {
  Network& network = part.network;
  std::vector<int> number(network.nodes, -1);
  std::fill_n(number.begin(), kept, 0);
  std::size_t links = 0;
  for (std::size_t k = 0; k < network.links.size(); ++k) {
    if (!chosen[k]) continue;
    const Link link = network.links[k];
    number[link.a] = number[link.b] = 0;
    part.link[links] = part.link[k];
    network.links[links++] = link;
  }
  network.links.resize(links);
  part.link.resize(links);
  int nodes = 0;
  for (int n = 0; n < network.nodes; ++n) {
    if (number[n] < 0) continue;
    if (!network.position.empty()) network.position[nodes] = network.position[n];
    part.node[nodes] = part.node[n];
    number[n] = nodes++;
  }
  network.nodes = nodes;
  part.node.resize(nodes);
  if (!network.position.empty()) network.position.resize(nodes);
  for (Link& link : network.links) link.a = number[link.a], link.b = number[link.b];
}

}  // namespace lichtenberg::network
