#pragma once

#include <Eigen/Core>
#include <vector>

#include "solvers/network/network.hpp"

namespace lichtenberg::network {

/// The network as its kept nodes see it: [kept, kept] conductances (S) between them, zero diagonal. Those that no path
/// joins have none. Throws InputError if a node is kept twice or not in the network.
Eigen::MatrixXd condense(const Network& network, const std::vector<int>& kept);

}  // namespace lichtenberg::network
