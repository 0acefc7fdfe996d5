#pragma once

#include <vector>

#include "solvers/network/network.hpp"

namespace lichtenberg::network {

/// Connected components of a network, by union-find; numbered by their first node.
struct Components {
  int number = 0;
  std::vector<int> of;  ///< [nodes] component of each node
};
Components components(const Network& network);

/// Returns the links that can carry a current from node a to node b: those on a simple path between the two. They are
/// the biconnected component of an additional link from a to b. Exact, from the graph alone, in linear time (Tarjan
/// 1972). A balanced bridge counts, although its current is zero. Returns [links]; all false if no path leads from a to
/// b.
std::vector<char> backbone(const Network& network, int a, int b);

}  // namespace lichtenberg::network
