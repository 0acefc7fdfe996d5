#pragma once

#include <vector>

#include "solvers/network/network.hpp"

namespace lichtenberg::network {

/// Current source between two nodes of a network: `current` (A) enters at node `high` and leaves at node `low`.
struct Feed {
  int low = 0, high = 1;
  double current = 0;
};

/// Computes the current (A) through each link, from its node a to its node b, with an error of at most 1e-9 of the
/// source's current. `potential` (V, [nodes]) must be accurate to rounding.
/// If a conductance g is so large that its two potentials agree in all digits, the product g (v_a - v_b) is dominated
/// by rounding. Connected links of this kind form clusters. The currents into a cluster follow from the other links.
/// Each cluster is solved again with these currents and with potentials relative to one of its nodes, recursively.
/// Below conductance ratios of about 1e6 this is not needed.
std::vector<double> link_currents(const Network& network, std::vector<double> potential, const Feed& feed);

}  // namespace lichtenberg::network
