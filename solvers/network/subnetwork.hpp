#pragma once

#include <span>
#include <vector>

#include "solvers/network/network.hpp"
#include "solvers/parallel/team.hpp"

namespace lichtenberg::network {

/// Part of a network, with its nodes and links in an order that keeps neighbours close in memory.
struct Subnetwork {
  Network network;
  std::vector<int> node;  ///< [nodes of the part] index in the whole network
  std::vector<int> link;  ///< [links of the part] index in the whole network
};

/// Returns a network in another order. The nodes `first` have the numbers 0, 1 ... The others follow by cells of their
/// positions, or without positions in the order of the links. Links are sorted by their smaller node.
Subnetwork reordered(const Network& network, const std::vector<int>& first, parallel::Team& team);

/// Removes the links k for which chosen[k] is zero, and the nodes without a link, except for the first `kept` nodes.
/// The order does not change.
void keep_links(Subnetwork& part, std::span<const char> chosen, int kept);

}  // namespace lichtenberg::network
