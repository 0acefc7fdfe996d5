#pragma once

#include <utility>

namespace lichtenberg::analysis {

/// Edge of a graph of conductors or points: two indices, the smaller first. An edge to ground is a conductor's index
/// and `to_ground` (network.hpp).
using Edge = std::pair<int, int>;

}  // namespace lichtenberg::analysis
