#pragma once

#include <vector>

#include "solvers/network/network.hpp"

namespace lichtenberg::network {

/// The pieces of a network that no link joins, by union-find. Numbered by their first node.
struct Components {
  int number = 0;
  std::vector<int> of;  ///< [nodes] piece of each node
};
Components components(const Network& network);

/// Which links can carry a current from node a to node b: those on some simple path between the two, that is the
/// biconnected piece that a link from a to b would close. Exact, decided on the graph alone; in linear time (Tarjan
/// 1972). A balanced bridge counts as carrying, although its current is zero.
/// Returns [links]; all false if no path leads from a to b.
std::vector<char> backbone(const Network& network, int a, int b);

}  // namespace lichtenberg::network
