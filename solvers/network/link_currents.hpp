#pragma once

#include <vector>

#include "solvers/network/network.hpp"

namespace lichtenberg::network {

/// Current source between two nodes of a network: `current` (A) enters at node `high` and leaves at node `low`.
struct Feed {
  int low = 0, high = 1;
  double current = 0;
};

/// Computes the current (A) through each link, from its node a to its node b, with a tolerance of 1e-9 of the source's
/// current. `potential` (V, [nodes]) must be accurate to rounding.
/// If a conductance g is so large that its two potentials agree in nearly all digits, the product g (v_a - v_b) is
/// dominated by rounding. Connected links of this kind form clusters. The currents into a cluster follow from the other
/// links. Each cluster is solved again with these currents and with potentials relative to one of its nodes,
/// recursively. Only links are affected whose conductance exceeds about 3e5 times the source's current over the largest
/// potential.
std::vector<double> link_currents(const Network& network, std::vector<double> potential, const Feed& feed);

}  // namespace lichtenberg::network
