#pragma once

#include <cstdint>
#include <vector>

#include "solvers/network/network.hpp"
#include "solvers/parallel/team.hpp"

namespace lichtenberg::network {

/// Method that solves for the currents of a resistor network.
enum class Method {
  automatic,    ///< Elimination, unless multigrid is likely to be faster or needed for lack of memory
  elimination,  ///< Star-mesh elimination (elimination.hpp)
  multigrid,    ///< Conjugate gradients with algebraic multigrid (multigrid.hpp); elimination if they do not converge
};

/// Options of conduct().
struct ConductionOptions {
  Method method = Method::automatic;
  double voltage = 1;        ///< Potential of the second electrode (V); the first is at 0
  double memory = 4e9;       ///< Bytes available to the elimination; in short memory it computes subtrees twice
  double tolerance = 1e-10;  ///< Tolerance of the multigrid: sum of unbalanced currents over the total current
  parallel::Team* team = &parallel::Team::single();  ///< Threads; they do not affect the results
};

/// Current flow through a resistor network between two of its nodes, the electrodes.
struct Conduction {
  bool connected = false;               ///< True if a path leads from one electrode to the other
  double conductance = 0;               ///< Conductance between the electrodes (S); 0 without a path
  double resistance = 0;                ///< Resistance between the electrodes (Ohm); infinite without a path
  double current = 0;                   ///< Current (A) from the second electrode through the network to the first
  double power = 0;                     ///< Dissipated power (W), the Joule heating of all links: sum of i^2 r
  double power_balance = 0;             ///< Relative error |power - V I| / (V I), checked: rounding or tolerance
  std::vector<double> potential;        ///< [nodes] Potential (V); NaN in a component without a path to an electrode
  std::vector<double> link_current;     ///< [links] Current (A) from a to b; exactly 0 outside the backbone
  std::vector<char> backbone;           ///< [links] True if the link can carry a current
  Method method = Method::elimination;  ///< Method used
  int unknowns = 0;                     ///< Nodes of the backbone without the electrodes
  std::int64_t entries = 0;             ///< Numbers in the factor of the elimination
  int iterations = 0;  ///< Iterations of the multigrid, also if it did not converge and `method` is elimination
};

/// Solves Kirchhoff's laws of a resistor network: computes potentials, link currents and resistance between node `low`
/// at 0 V and node `high` at options.voltage.
/// Only the backbone carries current. Dead ends have the potential of the node where they begin; components without a
/// path to an electrode have none (NaN). Both follow from the graph, so that rounding cannot connect a network without
/// a path.
/// Throws InputError if the electrodes are the same node or not in the network, and the exceptions of check(network).
/// Throws Failure if the dissipated power differs from voltage times current by more than the tolerance, or if a solver
/// fails.
Conduction conduct(const Network& network, int low, int high, const ConductionOptions& options = {});

/// Computes the effective (two-point) resistances (Ohm) between a node and every node, [nodes], by one elimination. The
/// resistance is 0 to the node itself, and infinite without a path. Throws InputError if there is no such node, and the
/// exceptions of check(network).
std::vector<double> resistances_from(const Network& network, int node);

/// Computes the effective conductance (S) between two nodes by elimination; 0 without a path. Throws InputError if the
/// nodes are equal or not in the network, and the exceptions of check(network).
double conductance_between(const Network& network, int low, int high, parallel::Team& team = parallel::Team::single());

}  // namespace lichtenberg::network
