#pragma once

#include <vector>

#include "solvers/network/network.hpp"
#include "solvers/parallel/team.hpp"

namespace lichtenberg::network {

/// Nested dissection of a network (George 1973): an elimination order of the nodes with little fill-in, divided into
/// fronts. A front is a set of nodes that are eliminated together as a dense block. It is either a separator,
/// eliminated after the parts of the network that it separates, or a small part itself.
struct Dissection {
  /// Front of the elimination: the nodes order[first] ... order[last - 1].
  struct Front {
    int first = 0, last = 0;
    int children = 0;  ///< Number of earlier fronts whose Schur complements this front adds (elimination tree)
  };
  std::vector<int> order;     ///< [nodes] All nodes in the order of elimination; the kept nodes are last
  std::vector<Front> fronts;  ///< Fronts in postorder: each is preceded by its children
  int pending = 0;            ///< Number of fronts without a parent; their Schur complements go to the kept nodes
};

/// Computes a nested dissection. `incidence`: that of the network; `kept`: [nodes], nonzero for nodes that are not
/// eliminated. A network with positions is cut recursively near the median along the axis of its largest extent, by the
/// threads of `team`, whose number does not affect the result. Without positions the library METIS finds the
/// separators; Failure is thrown if it fails.
Dissection dissect(const Network& network, const Incidence& incidence, const std::vector<char>& kept,
                   parallel::Team& team);

}  // namespace lichtenberg::network
