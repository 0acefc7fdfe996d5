#pragma once

#include <span>
#include <vector>

#include "solvers/laplace/network_factors.hpp"

namespace lichtenberg::laplace::device {

/// Groups of a grid that are relaxed together, in clusters of some each: row by row, cluster after cluster. One after
/// the other they would keep what they have in common, which CG's norm does not notice.
struct Clusters {
  std::vector<int> row;          ///< by group, or -1
  std::vector<int> group;        ///< by row
  std::vector<int> first, size;  ///< by row: its cluster's first row, and how many it has
  std::vector<long> start;       ///< by row: of its entries in `inverse`, one for each row of its cluster
  std::vector<double> inverse;   ///< potentials from what flows in, for given potentials of all other groups
};

/// Clusters of at most `most` groups that are joined by the strongest direct links, of those that outweigh the links to
/// cells of either end. `diagonal`: by group, the sum of all its conductances, 0: it has no potential of its own;
/// `links`: between such groups, each once.
Clusters clusters_of_direct_links(std::span<const double> diagonal, std::vector<NetworkLink> links, int most);

}  // namespace lichtenberg::laplace::device
