#pragma once

#include <vector>

#include "solvers/network/network.hpp"

namespace lichtenberg::network {

/// The order in which nodes are eliminated, and the fronts that do it: nested dissection (George 1973). A front is a
/// separator, eliminated when the parts that it separates are done, or a small part itself.
struct Dissection {
  struct Front {
    int first = 0, last = 0;  ///< eliminates order[first] ... order[last - 1]
    int children = 0;         ///< fronts just before it whose results it takes in, each with its own before it
  };
  std::vector<int> order;     ///< [nodes] all nodes, the kept ones last
  std::vector<Front> fronts;  ///< children before parents
  int pending = 0;            ///< fronts whose results nobody took: the kept nodes'
};

/// Cuts at the median of the longest coordinate, again and again, where the network has positions; otherwise METIS
/// finds the separators. `kept` ([nodes], nonzero: not eliminated).
Dissection dissect(const Network& network, const std::vector<char>& kept);

}  // namespace lichtenberg::network
