#pragma once

#include <vector>

#include "solvers/network/network.hpp"

namespace lichtenberg::network {

/// Current (A) that enters a network at one node and leaves it at another.
struct Feed {
  int low = 0, high = 1;
  double current = 0;
};

/// Returns the currents (A) through the links from a to b, each to 1e-9 of the injected current or better. `potential`
/// (V, [nodes]) must be accurate to rounding.
/// The product g (v_a - v_b) is dominated by rounding if a conductance is so large that both potentials agree in all
/// digits. The currents into and out of clusters of such links follow from the other links. Each cluster is therefore
/// solved again with these currents, and with potentials relative to one of its nodes, recursively. For ratios of
/// conductances below about 1e6 this is not needed.
std::vector<double> link_currents(const Network& network, std::vector<double> potential, const Feed& feed);

}  // namespace lichtenberg::network
