#pragma once

#include <vector>

#include "solvers/network/network.hpp"

namespace lichtenberg::network {

/// Connected components of a network, numbered in the order of their first nodes.
struct Components {
  int number = 0;       ///< Number of components
  std::vector<int> of;  ///< [nodes] component of each node
};
/// Finds the connected components of a network by union-find.
Components components(const Network& network);

/// Finds the backbone between nodes a and b: the links that can carry a current because they are on a simple path from
/// a to b. Returns [links], true for links of the backbone; all are false if no path leads from a to b.
/// The backbone is the biconnected component of an additional link from a to b (Tarjan 1972). It follows from the graph
/// alone, in linear time. The bridge link of a balanced Wheatstone bridge belongs to it, although its current is zero.
std::vector<char> backbone(const Network& network, int a, int b);

}  // namespace lichtenberg::network
