#include "solvers/network/link_currents.hpp"

#include <algorithm>
#include <cmath>

#include "solvers/network/components.hpp"
#include "solvers/network/elimination.hpp"

namespace lichtenberg::network {
namespace {

constexpr double error_of_potentials = 16 * 2.2e-16;  ///< Error of potentials, relative to the largest in the cluster
constexpr double error_allowed = 1e-9;                ///< Tolerance of a link's current over the injected current

/// Links that are not resolved yet, with their nodes numbered from 1. Node 0 is common to all clusters and the
/// reference of their potentials. It changes no currents, because the current into a cluster also leaves it.
class Clusters {
 public:
  Clusters(const Network& whole, const std::vector<int>& links) {
    Network open{.nodes = whole.nodes};
    for (const int k : links) open.links.push_back(whole.links[k]);
    const Components pieces = components(open);
    std::vector<char> counted_from(pieces.number, 0);
    number.assign(whole.nodes, -1);
    const auto visit = [&](int node) {
      if (number[node] >= 0) return number[node];
      char& has_ground = counted_from[pieces.of[node]];
      number[node] = has_ground ? network.nodes++ : 0;
      has_ground = 1;
      if (number[node] > 0) piece.push_back(pieces.of[node]);
      if (number[node] > 0 && !whole.position.empty()) network.position.push_back(whole.position[node]);
      return number[node];
    };
    network.nodes = 1;
    piece.push_back(0);
    if (!whole.position.empty()) network.position.push_back(whole.position[0]);
    for (const Link& link : open.links) {
      const int a = visit(link.a), b = visit(link.b);
      network.links.push_back({a, b, link.conductance});
      piece_of_link.push_back(pieces.of[link.a]);
    }
    number_of_pieces = pieces.number;
  }

  /// Returns the potentials of the nodes for the injected currents.
  Eigen::VectorXd solve(const Eigen::VectorXd& injected) const {
    return Elimination(network, {0}).potentials(Eigen::MatrixXd::Zero(1, 1), injected);
  }

  /// Returns, [links], the largest potential in each link's cluster.
  std::vector<double> scale(const Eigen::VectorXd& potential) const {
    std::vector<double> largest(number_of_pieces, 0);
    for (int n = 1; n < network.nodes; ++n) largest[piece[n]] = std::max(largest[piece[n]], std::abs(potential[n]));
    std::vector<double> result;
    for (const int p : piece_of_link) result.push_back(largest[p]);
    return result;
  }

  Network network;
  std::vector<int> number;  ///< [nodes of the whole network] number of each node, -1: not in a cluster

 private:
  std::vector<int> piece, piece_of_link;
  int number_of_pieces = 0;
};

/// Returns the currents injected into all nodes by the source and the resolved links.
std::vector<double> injected_currents(const Network& network, const std::vector<double>& current,
                                      const std::vector<char>& resolved, const Feed& feed) {
  std::vector<double> injected(network.nodes, 0);
  injected[feed.high] += feed.current;
  injected[feed.low] -= feed.current;
  for (std::size_t k = 0; k < network.links.size(); ++k) {
    if (!resolved[k]) continue;
    injected[network.links[k].a] -= current[k];
    injected[network.links[k].b] += current[k];
  }
  return injected;
}

}  // namespace

std::vector<double> link_currents(const Network& network, std::vector<double> potential, const Feed& feed) {
  const std::size_t n = network.links.size();
  std::vector<double> current(n);
  std::vector<char> resolved(n, 0);
  std::vector<int> open;
  double voltage = 0;
  for (const double v : potential) voltage = std::max(voltage, std::abs(v));
  const auto take = [&](int k, double difference, double scale) {
    const double g = network.links[k].conductance;
    current[k] = g * difference;
    resolved[k] = g * scale * error_of_potentials <= error_allowed * std::abs(feed.current);
    if (!resolved[k]) open.push_back(k);
  };
  for (std::size_t k = 0; k < n; ++k)
    take(static_cast<int>(k), potential[network.links[k].a] - potential[network.links[k].b], voltage);
  for (std::size_t before = n + 1; !open.empty() && open.size() < before;) {
    before = open.size();
    const std::vector<int> links = std::move(open);
    open.clear();
    const Clusters clusters(network, links);
    const std::vector<double> injected_whole = injected_currents(network, current, resolved, feed);
    Eigen::VectorXd injected = Eigen::VectorXd::Zero(clusters.network.nodes);
    for (int node = 0; node < network.nodes; ++node)
      if (clusters.number[node] > 0) injected[clusters.number[node]] = injected_whole[node];
    const Eigen::VectorXd relative = clusters.solve(injected);
    const std::vector<double> scale = clusters.scale(relative);
    for (std::size_t k = 0; k < links.size(); ++k) {
      const Link& link = clusters.network.links[k];
      take(links[k], relative[link.a] - relative[link.b], scale[k]);
    }
  }
  return current;
}

}  // namespace lichtenberg::network
