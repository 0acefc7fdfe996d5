#pragma once

#include <Eigen/Core>
#include <vector>

#include "solvers/network/network.hpp"

namespace lichtenberg::network {

/// Computes the equivalent network of a resistor network between some of its nodes, `kept` (Kron reduction, Schur
/// complement of the conductance matrix). Returns the conductances (S) [kept, kept] between these nodes, with zero
/// diagonal, and zero without a path. Throws InputError if a kept node is listed twice or not in the network, or if a
/// conductance is not positive.
Eigen::MatrixXd condense(const Network& network, const std::vector<int>& kept);

}  // namespace lichtenberg::network
