#include "solvers/network/conduction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "solvers/error.hpp"
#include "solvers/network/components.hpp"
#include "solvers/network/condense.hpp"
#include "solvers/network/elimination.hpp"
#include "solvers/network/link_currents.hpp"
#include "solvers/network/multigrid.hpp"
#include "solvers/network/subnetwork.hpp"
#include "solvers/parallel/ranges.hpp"

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

/// Sets the potential of dead ends, which links outside the backbone form, to that of the node where they begin.
void fill_dead_ends(const Network& network, const std::vector<char>& backbone, std::vector<double>& potential) {
  Network dead{.nodes = network.nodes};
  for (std::size_t k = 0; k < network.links.size(); ++k)
    if (!backbone[k]) dead.links.push_back(network.links[k]);
  const Incidence incidence(dead);
  std::vector<int> reached;
  for (int n = 0; n < network.nodes; ++n)
    if (!std::isnan(potential[n]) && !incidence.of(n).empty()) reached.push_back(n);
  for (std::size_t k = 0; k < reached.size(); ++k)
    for (const int link : incidence.of(reached[k])) {
      const int next = other_end(dead.links[link], reached[k]);
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

Elimination::Options elimination_options(const Network& network, const ConductionOptions& options) {
  const auto [least, most] = std::ranges::minmax(network.links, {}, &Link::conductance);
  const bool wide = most.conductance > widest_for_multigrid * least.conductance;
  return {.bytes = options.memory,
          .operations =
              options.method == Method::multigrid ? -1 : operations_a_link * static_cast<double>(network.links.size()),
          .required = options.method == Method::elimination || (options.method == Method::automatic && wide),
          .team = options.team};
}

std::vector<double> eliminate(const Network& network, const Elimination& elimination, double voltage,
                              Conduction& result) {
  result.method = Method::elimination;
  result.entries = elimination.entries();
  result.conductance = elimination.mesh()(1, 0);
  result.current = voltage * result.conductance;
  const Eigen::VectorXd v = elimination.potentials(Eigen::Vector2d(0, voltage));
  result.potential.assign(v.data(), v.data() + v.size());
  return link_currents(network, result.potential, {.low = 0, .high = 1, .current = result.current});
}

/// Returns the link currents; empty if the multigrid does not converge.
std::optional<std::vector<double>> iterate(const Network& network, const ConductionOptions& options,
                                           Conduction& result) {
  MultigridSolution solution = solve_by_multigrid(network, 0, 1, options.voltage, options.tolerance);
  result.iterations = solution.iterations;
  if (!solution.converged) return {};
  result.method = Method::multigrid;
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
  Elimination::Options elimination = elimination_options(network, options);
  const Elimination within_limits(network, {0, 1}, elimination);
  if (within_limits.done()) return eliminate(network, within_limits, options.voltage, result);
  if (auto current = iterate(network, options, result)) return *std::move(current);
  elimination.operations = std::numeric_limits<double>::infinity();
  const Elimination any_time(network, {0, 1}, elimination);
  if (!any_time.done())
    throw Failure(
        fmt::format("the multigrid of the network did not converge in {} iterations, and its elimination "
                    "needs more than {:.2g} bytes",
                    result.iterations, options.memory));
  return eliminate(network, any_time, options.voltage, result);
}

}  // namespace

Conduction conduct(const Network& network, int low, int high, const ConductionOptions& options) {
  check(network);
  check_nodes(network, {low, high});
  Conduction result;
  result.backbone.assign(network.links.size(), 0);
  result.link_current.assign(network.links.size(), 0);
  std::vector<double> potential(network.nodes, NAN);
  potential[low] = 0;
  potential[high] = options.voltage;
  Subnetwork part = reordered(network, {low, high}, *options.team);
  keep_links(part, backbone(part.network, 0, 1), 2);
  result.connected = !part.network.links.empty();
  if (result.connected) {
    const std::vector<double> current = solve(part.network, options, result);
    for (int n = 0; n < part.network.nodes; ++n) potential[part.node[n]] = result.potential[n];
    for (std::size_t k = 0; k < current.size(); ++k) {
      result.link_current[part.link[k]] = current[k];
      result.backbone[part.link[k]] = 1;
    }
    result.unknowns = part.network.nodes - 2;
  }
  fill_dead_ends(network, result.backbone, potential);
  result.potential = std::move(potential);
  result.resistance = result.connected ? 1 / result.conductance : std::numeric_limits<double>::infinity();
  if (result.connected) check_power(result, network, options);
  return result;
}

namespace {

/// Returns the part of a network that is connected to one of the kept nodes, which come first.
Subnetwork reachable_from(const Network& network, const std::vector<int>& kept, parallel::Team& team) {
  check(network);
  check_nodes(network, kept);
  Subnetwork part = reordered(network, kept, team);
  const Components pieces = components(part.network);
  std::vector<char> has_kept(pieces.number, 0), chosen(part.network.links.size());
  for (std::size_t k = 0; k < kept.size(); ++k) has_kept[pieces.of[k]] = 1;
  parallel::for_each_range(chosen.size(), team, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) chosen[k] = has_kept[pieces.of[part.network.links[k].a]];
  });
  keep_links(part, chosen, static_cast<int>(kept.size()));
  return part;
}

}  // namespace

std::vector<double> resistances_from(const Network& network, int node) {
  const Subnetwork part = reachable_from(network, {node}, parallel::Team::single());
  const Eigen::VectorXd found = Elimination(part.network, {0}).resistances();
  std::vector<double> resistance(network.nodes, std::numeric_limits<double>::infinity());
  for (int n = 0; n < part.network.nodes; ++n) resistance[part.node[n]] = found(n);
  return resistance;
}

double conductance_between(const Network& network, int low, int high, parallel::Team& team) {
  return condense(network, {low, high}, team)(1, 0);
}

Eigen::MatrixXd condense(const Network& network, const std::vector<int>& kept, parallel::Team& team) {
  const Subnetwork part = reachable_from(network, kept, team);
  std::vector<int> first(kept.size());
  std::iota(first.begin(), first.end(), 0);
  return Elimination(part.network, first, {.mesh_only = true, .team = &team}).mesh();
}

}  // namespace lichtenberg::network
