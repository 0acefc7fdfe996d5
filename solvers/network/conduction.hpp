#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "solvers/network/network.hpp"

namespace lichtenberg::network {

/// How the currents of a network are found.
enum class Method {
  automatic,    ///< elimination, unless multigrid is likely to be faster or alone fits into the memory
  elimination,  ///< star-mesh elimination (elimination.hpp)
  multigrid,    ///< conjugate gradients with algebraic multigrid (multigrid.hpp)
};

struct ConductionOptions {
  Method method = Method::automatic;
  double voltage = 1;        ///< V, of the second electrode; the first is at 0
  double memory = 4e9;       ///< bytes that the elimination may take
  double tolerance = 1e-10;  ///< of the multigrid: currents out of balance, relative to the current
};

/// What flows through a network between two of its nodes.
struct Conduction {
  bool connected = false;            ///< some path leads from one electrode to the other
  double conductance = 0;            ///< S; 0 without a path
  double resistance = 0;             ///< Ohm; infinite without a path
  double current = 0;                ///< A, out of the second electrode and into the first
  double power = 0;                  ///< W, sum over the links of i^2 r
  double power_balance = 0;          ///< |power - V I| / (V I): zero but for rounding, checked
  std::vector<double> potential;     ///< [nodes] V; NaN in a piece that no path joins to an electrode
  std::vector<double> link_current;  ///< [links] A, from a to b; exactly 0 outside of the backbone
  std::vector<char> backbone;        ///< [links] can carry a current
  std::vector<int> component;        ///< [nodes] which piece of the network
  Method method = Method::elimination;
  int unknowns = 0;          ///< nodes of the backbone without the electrodes
  std::int64_t entries = 0;  ///< stored by the elimination
  int iterations = 0;        ///< of the multigrid
};

/// Potentials and currents between node `low` at 0 V and node `high` at options.voltage. Pieces of the network that
/// join neither electrode float, and a dead end has the potential of the node where it begins; both are found on the
/// graph, so that a network without a path has no resistance by rounding. Throws InputError if the electrodes are the
/// same node or not in the network, or a link's conductance is not positive; Failure if powers do not balance.
Conduction conduct(const Network& network, int low, int high, const ConductionOptions& options = {});

/// Effective resistances (Ohm) from a node to each, [nodes], by one elimination: 0 to itself, infinite without a path.
/// Throws InputError if there is no such node or a link's conductance is not positive.
std::vector<double> resistances_from(const Network& network, int node);

/// Conductance between two nodes (S) and nothing else, by elimination: 0 without a path.
double conductance_between(const Network& network, int low, int high);

}  // namespace lichtenberg::network
