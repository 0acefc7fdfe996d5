#pragma once

#include <cstdint>
#include <vector>

#include "solvers/network/network.hpp"

namespace lichtenberg::network {

/// Methods for the currents of a network.
enum class Method {
  automatic,    ///< Elimination, unless multigrid is likely to be faster or needed for lack of memory
  elimination,  ///< Star-mesh elimination (elimination.hpp)
  multigrid,    ///< Conjugate gradients with algebraic multigrid (multigrid.hpp)
};

struct ConductionOptions {
  Method method = Method::automatic;
  double voltage = 1;        ///< Potential of the second electrode (V); the first is at 0
  double memory = 4e9;       ///< Bytes available to the elimination
  double tolerance = 1e-10;  ///< Tolerance of the multigrid: unbalanced currents, relative to the current
};

/// Current flow through a network between two of its nodes.
struct Conduction {
  bool connected = false;            ///< True if a path leads from one electrode to the other
  double conductance = 0;            ///< S; 0 without a path
  double resistance = 0;             ///< Ohm; infinite without a path
  double current = 0;                ///< A, out of the second electrode and into the first
  double power = 0;                  ///< W, sum over the links of i^2 r
  double power_balance = 0;          ///< |power - V I| / (V I): zero except for rounding, checked
  std::vector<double> potential;     ///< [nodes] V; NaN in a component without a path to an electrode
  std::vector<double> link_current;  ///< [links] A, from a to b; exactly 0 outside the backbone
  std::vector<char> backbone;        ///< [links] true if the link can carry a current
  std::vector<int> component;        ///< [nodes] connected component
  Method method = Method::elimination;
  int unknowns = 0;          ///< Nodes of the backbone without the electrodes
  std::int64_t entries = 0;  ///< Numbers stored by the elimination
  int iterations = 0;        ///< Iterations of the multigrid
};

/// Solves Kirchhoff's laws: computes potentials and currents between node `low` at 0 V and node `high` at
/// options.voltage. Components without a path to an electrode float, and dead ends have the potential of the node where
/// they begin. Both follow from the graph, so that rounding cannot connect a network without a path. Throws InputError
/// if the electrodes are the same node or not in the network, or if a conductance is not positive. Throws Failure if
/// powers do not balance.
Conduction conduct(const Network& network, int low, int high, const ConductionOptions& options = {});

/// Returns the effective resistances (Ohm) from a node to each, [nodes], by one elimination: 0 to itself, infinite
/// without a path. Throws InputError if there is no such node or a conductance is not positive.
std::vector<double> resistances_from(const Network& network, int node);

/// Returns the conductance (S) between two nodes by elimination; 0 without a path.
double conductance_between(const Network& network, int low, int high);

}  // namespace lichtenberg::network
