#pragma once

#include <utility>

namespace lichtenberg::analysis {

/// Of a graph of conductors or points: two of them, the smaller index first, or one and `to_ground` (network.hpp).
using Edge = std::pair<int, int>;

}  // namespace lichtenberg::analysis
