#pragma once

#include <vector>

#include "solvers/network/network.hpp"

namespace lichtenberg::network {

/// Elimination order of the nodes, and the fronts of the elimination: nested dissection (George 1973). A front is a
/// separator, eliminated after the parts that it separates, or a small part itself.
struct Dissection {
  struct Front {
    int first = 0, last = 0;  ///< Eliminates order[first] ... order[last - 1]
    int children = 0;         ///< Number of preceding fronts whose results it takes in, each preceded by its own
                              ///< children
  };
  std::vector<int> order;     ///< [nodes] all nodes, the kept ones last
  std::vector<Front> fronts;  ///< Fronts, children before parents
  int pending = 0;            ///< Number of fronts whose results go to the kept nodes
};

/// Computes the dissection. With positions it cuts recursively at the median of the longest coordinate; otherwise METIS
/// finds the separators. `kept`: [nodes], nonzero for nodes that are not eliminated.
Dissection dissect(const Network& network, const std::vector<char>& kept);

}  // namespace lichtenberg::network
