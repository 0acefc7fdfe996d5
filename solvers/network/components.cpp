#include "solvers/network/components.hpp"

#include <algorithm>

#include "solvers/disjoint_sets.hpp"

namespace lichtenberg::network {
namespace {

/// Depth-first search from node a for biconnected components (Hopcroft and Tarjan). low[n] is the earliest visited node
/// that the subtree of n reaches by one back edge.
class DepthFirst {
 public:
  DepthFirst(const Network& network, const Incidence& incidence)
      : network_(network),
        incidence_(incidence),
        visit(network.nodes, -1),
        low(network.nodes, 0),
        parent_link(network.nodes, -1),
        next_(incidence.start.begin(), incidence.start.end() - 1) {}

  /// Searches from a, and first along an additional link from a to b, with a number after all others.
  void from(int a, int b) {
    enter(a, -1);
    enter(b, static_cast<int>(network_.links.size()));
    while (!path_.empty()) {
      const int node = path_.back();
      if (next_[node] == incidence_.start[node + 1])
        leave(node);
      else
        follow(node, incidence_.link[next_[node]++]);
    }
  }

 private:
  void enter(int node, int link) {
    visit[node] = low[node] = static_cast<int>(order.size());
    parent_link[node] = link;
    order.push_back(node);
    path_.push_back(node);
  }
  void follow(int node, int link) {
    if (link == parent_link[node]) return;
    const int to = other_end(network_.links[link], node);
    if (visit[to] < 0)
      enter(to, link);
    else
      low[node] = std::min(low[node], visit[to]);
  }
  void leave(int node) {
    path_.pop_back();
    if (!path_.empty()) low[path_.back()] = std::min(low[path_.back()], low[node]);
  }

  const Network& network_;
  const Incidence& incidence_;

 public:
  std::vector<int> visit, low, parent_link, order;

 private:
  std::vector<int> next_, path_;
};

}  // namespace

Components components(const Network& network) {
  DisjointSets sets(network.nodes);
  for (const Link& link : network.links) sets.unite(link.a, link.b);
  Components result{.of = std::vector<int>(network.nodes)};
  for (int node = 0; node < network.nodes; ++node) {
    const int first = sets.find(node);
    result.of[node] = first == node ? result.number++ : result.of[first];
  }
  return result;
}

std::vector<char> backbone(const Network& network, int a, int b) {
  // With an additional link from a to b, the links that carry current are the biconnected component of that link,
  // which is the tree path from a (the root) to b. A subtree belongs to it if its parent does and if it reaches above
  // its parent.
  const Incidence incidence(network);
  DepthFirst walk(network, incidence);
  walk.from(a, b);
  std::vector<char> below(network.nodes, 0);  // True if the tree link to the node's parent is in the component
  below[b] = 1;
  for (const int node : walk.order) {
    if (node == a || node == b) continue;
    const int p = other_end(network.links[walk.parent_link[node]], node);
    below[node] = p != a && below[p] && walk.low[node] < walk.visit[p];
  }
  std::vector<char> carries(network.links.size(), 0);
  for (std::size_t k = 0; k < network.links.size(); ++k) {
    const Link& link = network.links[k];
    if (link.a == link.b || walk.visit[link.a] < 0) continue;
    const int later = walk.visit[link.a] > walk.visit[link.b] ? link.a : link.b;  // End of a back edge
    carries[k] = below[later];
  }
  return carries;
}

}  // namespace lichtenberg::network
