#pragma once

#include <Eigen/Core>
#include <vector>

#include "solvers/network/network.hpp"
#include "solvers/parallel/team.hpp"

namespace lichtenberg::network {

/// Computes the equivalent network of a resistor network between some of its nodes, `kept` (Kron reduction, Schur
/// complement of the conductance matrix). Returns the conductances (S) [kept, kept] between these nodes, with zero
/// diagonal; 0 for nodes without a path between them. Throws InputError if a kept node is listed twice or not in the
/// network. Also throws the exceptions of check(network). The threads of `team` do not affect the result.
Eigen::MatrixXd condense(const Network& network, const std::vector<int>& kept,
                         parallel::Team& team = parallel::Team::single());

}  // namespace lichtenberg::network
