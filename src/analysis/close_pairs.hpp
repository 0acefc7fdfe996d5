#pragma once

#include <span>
#include <utility>
#include <vector>

#include "solvers/geometry/vec2.hpp"

namespace lichtenberg::analysis {

/// All pairs (i < j, in ascending order) of points closer than `reach` (m), found with a cell list: the work grows with
/// the number of points and of pairs.
std::vector<std::pair<int, int>> close_pairs(std::span<const Vec2> points, double reach);

}  // namespace lichtenberg::analysis
