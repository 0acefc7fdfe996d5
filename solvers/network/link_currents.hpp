#pragma once

#include <vector>

#include "solvers/network/network.hpp"

namespace lichtenberg::network {

/// A current (A) that enters a network at one node and leaves it at another.
struct Feed {
  int low = 0, high = 1;
  double current = 0;
};

/// Currents (A) through the links from a to b, each to 1e-9 of the current fed or better, for potentials (V, [nodes])
/// that are right to rounding.
///
/// g (v_a - v_b) is lost in rounding where a conductance is so large that its ends have one potential in all digits
/// kept. What flows into and out of such clusters of large conductances is known, though, from the other links; so each
/// cluster is solved again on its own, with these currents fed in and potentials counted from one of its nodes, and so
/// on. Without such links, that is for ratios of conductances below some 1e6, there is nothing to do.
std::vector<double> link_currents(const Network& network, std::vector<double> potential, const Feed& feed);

}  // namespace lichtenberg::network
