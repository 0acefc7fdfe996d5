#pragma once

#include <vector>

#include "solvers/network/network.hpp"
#include "solvers/parallel/team.hpp"

namespace lichtenberg::network {

/// Returns the indices of points in an order that keeps neighbours close in memory: by cells of some dozen points in
/// Morton's order, and ascending within a cell.
std::vector<int> spatial_order(const std::vector<Point>& position, parallel::Team& team);

}  // namespace lichtenberg::network
