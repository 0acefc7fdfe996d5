#pragma once

#include <Eigen/Core>
#include <vector>

#include "solvers/network/network.hpp"

namespace lichtenberg::network {

/// Condenses the network to its kept nodes: returns the conductances (S) [kept, kept] between them, with zero diagonal,
/// and zero without a path. Throws InputError if a kept node is listed twice or not in the network.
Eigen::MatrixXd condense(const Network& network, const std::vector<int>& kept);

}  // namespace lichtenberg::network
