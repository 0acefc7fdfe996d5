#include "solvers/network/conduction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "solvers/error.hpp"
#include "solvers/network/components.hpp"
#include "solvers/network/condense.hpp"
#include "solvers/network/elimination.hpp"
#include "solvers/network/link_currents.hpp"
#include "solvers/network/multigrid.hpp"

namespace lichtenberg::network {
namespace {

void check_nodes(const Network& network, const std::vector<int>& nodes) {
  std::vector<int> sorted = nodes;
  std::ranges::sort(sorted);
  for (std::size_t k = 0; k < sorted.size(); ++k) {
    if (sorted[k] < 0 || sorted[k] >= network.nodes)
      throw InputError(fmt::format("there is no node {}: the network has nodes 0 to {}", sorted[k], network.nodes - 1));
    if (k > 0 && sorted[k] == sorted[k - 1])
      throw InputError(fmt::format("node {} is named twice: electrodes must be different nodes", sorted[k]));
  }
}

/// Subset of a network's links, with the nodes at their ends.
struct Subnetwork {
  Network network;
  std::vector<int> node;    ///< [nodes of the part] index in the whole network
  std::vector<int> number;  ///< [nodes of the whole network] index in the part, or -1
};

/// Extracts a part. `first`: nodes that come first in any case. `chosen(k)`: true if link k is in the part.
template <class Chosen>
Subnetwork extract(const Network& network, const std::vector<int>& first, const Chosen& chosen) {
  Subnetwork subnetwork{.number = std::vector<int>(network.nodes, -1)};
  const auto number = [&](int node) {
    if (subnetwork.number[node] < 0) {
      subnetwork.number[node] = static_cast<int>(subnetwork.node.size());
      subnetwork.node.push_back(node);
    }
    return subnetwork.number[node];
  };
  for (const int node : first) number(node);
  for (std::size_t k = 0; k < network.links.size(); ++k)
    if (const Link& link = network.links[k]; chosen(k))
      subnetwork.network.links.push_back({number(link.a), number(link.b), link.conductance});
  subnetwork.network.nodes = static_cast<int>(subnetwork.node.size());
  if (!network.position.empty())
    for (const int node : subnetwork.node) subnetwork.network.position.push_back(network.position[node]);
  return subnetwork;
}

/// Sets the potential of dead ends to that of the node where they begin.
void fill_dead_ends(const Network& network, std::vector<double>& potential) {
  const Incidence incidence(network);
  std::vector<int> reached;
  for (int n = 0; n < network.nodes; ++n)
    if (!std::isnan(potential[n])) reached.push_back(n);
  for (std::size_t k = 0; k < reached.size(); ++k)
    for (const int link : incidence.of(reached[k])) {
      const int next = other_end(network.links[link], reached[k]);
      if (!std::isnan(potential[next])) continue;
      potential[next] = potential[reached[k]];
      reached.push_back(next);
    }
}

/// Checks the balance of powers. For potentials with rounding errors, sum i^2 r has an error of second order, and a
/// summation error of one eps per link. With the multigrid the error is V times the unbalanced currents. Terms are
/// divided by V I before summation, because squares of small currents underflow.
void check_power(Conduction& result, const Network& network, const ConductionOptions& options) {
  double share = 0;
  for (std::size_t k = 0; k < network.links.size(); ++k) {
    const double drop = result.link_current[k] / network.links[k].conductance;
    share += result.link_current[k] / result.current * (drop / options.voltage);
  }
  const double expected = result.current * options.voltage;
  result.power = share * expected;
  result.power_balance = std::abs(share - 1);
  const double rounding = std::max(1e-12, 8e-16 * static_cast<double>(network.links.size()));
  const double allowed = rounding + (result.method == Method::multigrid ? options.tolerance : 0);
  if (!(result.power_balance <= allowed))
    throw Failure(fmt::format("the network's power does not balance: sum of i^2 r = {:.15g} W, V I = {:.15g} W",
                              result.power, expected));
}

/// Ratio of conductances above which only the elimination is accurate: the multigrid's potentials lose digits.
constexpr double widest_for_multigrid = 1e6;
/// Number of elimination operations per link that take as long as the multigrid, times two in favour of the
/// elimination, whose time is predictable (docs/numerics/networks.md).
constexpr double operations_a_link = 3e4;

Elimination::Limits limits(const Network& network, const ConductionOptions& options) {
  if (options.method == Method::elimination || network.links.empty()) return {};
  if (options.method == Method::multigrid) return {.operations = -1};
  const auto [least, most] = std::ranges::minmax(network.links, {}, &Link::conductance);
  if (most.conductance > widest_for_multigrid * least.conductance) return {};
  return {.bytes = options.memory, .operations = operations_a_link * static_cast<double>(network.links.size())};
}

std::vector<double> eliminate(const Network& network, const Elimination& elimination, double voltage,
                              Conduction& result) {
  result.method = Method::elimination;
  result.entries = elimination.stored_entries();
  result.conductance = elimination.mesh()(1, 0);
  result.current = voltage * result.conductance;
  const Eigen::VectorXd v = elimination.potentials(Eigen::Vector2d(0, voltage));
  result.potential.assign(v.data(), v.data() + v.size());
  return link_currents(network, result.potential, {.low = 0, .high = 1, .current = result.current});
}

std::vector<double> iterate(const Network& network, const ConductionOptions& options, Conduction& result) {
  MultigridSolution solution = solve_by_multigrid(network, 0, 1, options.voltage, options.tolerance);
  result.method = Method::multigrid;
  result.iterations = solution.iterations;
  result.potential = std::move(solution.potential);
  std::vector<double> current;
  double power = 0;
  for (const Link& link : network.links) {
    const double difference = result.potential[link.a] - result.potential[link.b];
    current.push_back(link.conductance * difference);
    power += difference * current.back();
    if (link.b == 0) result.current += current.back();
    if (link.a == 0) result.current -= current.back();
  }
  result.conductance = power / (options.voltage * options.voltage);
  return current;
}

/// Solves a network in which all links can carry a current, between node 0 and node 1; returns the link currents.
std::vector<double> solve(const Network& network, const ConductionOptions& options, Conduction& result) {
  const Elimination elimination(network, {0, 1}, limits(network, options));
  return elimination.done() ? eliminate(network, elimination, options.voltage, result)
                            : iterate(network, options, result);
}

}  // namespace

Conduction conduct(const Network& network, int low, int high, const ConductionOptions& options) {
  check(network);
  check_nodes(network, {low, high});
  Conduction result;
  result.component = components(network).of;
  result.connected = result.component[low] == result.component[high];
  result.backbone = backbone(network, low, high);
  result.link_current.assign(network.links.size(), 0);
  std::vector<double> potential(network.nodes, NAN);
  potential[low] = 0;
  potential[high] = options.voltage;
  if (result.connected) {
    const Subnetwork subnetwork = extract(network, {low, high}, [&](std::size_t k) { return result.backbone[k] != 0; });
    const std::vector<double> current = solve(subnetwork.network, options, result);
    for (int n = 0; n < subnetwork.network.nodes; ++n) potential[subnetwork.node[n]] = result.potential[n];
    for (std::size_t k = 0, carrying = 0; k < network.links.size(); ++k)
      if (result.backbone[k]) result.link_current[k] = current[carrying++];
    result.unknowns = subnetwork.network.nodes - 2;
  }
  fill_dead_ends(network, potential);
  result.potential = std::move(potential);
  result.resistance = result.connected ? 1 / result.conductance : std::numeric_limits<double>::infinity();
  if (result.connected) check_power(result, network, options);
  return result;
}

std::vector<double> resistances_from(const Network& network, int node) {
  check(network);
  check_nodes(network, {node});
  const std::vector<int> component = components(network).of;
  const Subnetwork subnetwork =
      extract(network, {node}, [&](std::size_t k) { return component[network.links[k].a] == component[node]; });
  const Eigen::VectorXd found = Elimination(subnetwork.network, {0}).resistances();
  std::vector<double> resistance(network.nodes, std::numeric_limits<double>::infinity());
  for (int n = 0; n < subnetwork.network.nodes; ++n) resistance[subnetwork.node[n]] = found(n);
  return resistance;
}

double conductance_between(const Network& network, int low, int high) {
  check_nodes(network, {low, high});
  return condense(network, {low, high})(1, 0);
}

Eigen::MatrixXd condense(const Network& network, const std::vector<int>& kept) {
  check(network);
  check_nodes(network, kept);
  const Components parts = components(network);
  std::vector<char> has_kept(parts.number, 0);
  for (const int n : kept) has_kept[parts.of[n]] = 1;
  const auto seen = [&](int n) { return has_kept[parts.of[n]] != 0; };
  const bool whole = std::ranges::all_of(has_kept, [](char c) { return c != 0; });
  if (whole) return Elimination(network, kept).mesh();
  const Subnetwork subnetwork = extract(network, kept, [&](std::size_t k) { return seen(network.links[k].a); });
  std::vector<int> first(kept.size());
  std::iota(first.begin(), first.end(), 0);
  return Elimination(subnetwork.network, first).mesh();
}

}  // namespace lichtenberg::network
