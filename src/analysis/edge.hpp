#pragma once

#include <utility>

namespace lichtenberg::analysis {

/// Edge of a graph of conductors or points: two indices, the smaller first, or one index and `to_ground` (network.hpp).
using Edge = std::pair<int, int>;

}  // namespace lichtenberg::analysis
