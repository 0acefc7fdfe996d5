#include "src/analysis/network.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "src/model/neighbours.hpp"

namespace lichtenberg::analysis {

Ground ground_of(const Scene& scene) {
  Ground ground;
  ground.size = plane(scene.domain.size);
  for (size_t k = 0; k < ground.side.size(); ++k) ground.side[k] = scene.domain.sides[k].electrode;
  for (const Electrode& electrode : scene.electrodes) ground.bodies.push_back(electrode.shape);
  return ground;
}

double gap(const Disk& disk, const Ground& ground) {
  const Vec2 c = disk.centre;
  const std::array<double, 4> distance{c.x, ground.size.x - c.x, c.y, ground.size.y - c.y};
  double smallest = std::numeric_limits<double>::infinity();
  for (size_t k = 0; k < distance.size(); ++k)
    if (ground.side[k]) smallest = std::min(smallest, distance[k] - disk.radius);
  for (const Shape& body : ground.bodies) smallest = std::min(smallest, gap(disk, body));
  return smallest;
}

std::vector<Edge> contacts(std::span<const Vec2> position, std::span<const double> radius, double contact_gap,
                           const Ground& ground) {
  Bodies bodies;
  for (const Vec2 p : position) bodies.position.insert(bodies.position.end(), {p.x, p.y});
  bodies.radius.assign(radius.begin(), radius.end());
  std::vector<Edge> found;
  for (int i = 0; i < bodies.size(); ++i)
    if (gap(Disk{position[i], radius[i]}, ground) < contact_gap) found.emplace_back(i, to_ground);
  for (const auto [i, j] : pairs_closer_than(bodies, contact_gap)) found.emplace_back(i, j);
  std::sort(found.begin(), found.end());
  return found;
}

ContactGraph contact_graph(int conductors, std::span<const Edge> contacts) {
  ContactGraph graph{std::vector<std::vector<int>>(conductors), std::vector<bool>(conductors)};
  for (const auto& [i, j] : contacts) {
    if (j == to_ground) {
      graph.grounded[i] = true;
    } else {
      graph.neighbours[i].push_back(j);
      graph.neighbours[j].push_back(i);
    }
  }
  return graph;
}

namespace {

template <int d>
std::vector<int> nearest_successors(const ContactGraph& graph, std::span<const Vec<d>> position) {
  const int n = static_cast<int>(position.size());
  std::vector<int> successor(n, unconnected), round(n, 0);
  std::vector<int> latest;  // conductors that got their successor in the previous round
  for (int i = 0; i < n; ++i)
    if (graph.grounded[i]) {
      successor[i] = to_ground;
      latest.push_back(i);
    }
  const auto distance2 = [&](int i, int j) { return norm2(position[i] - position[j]); };
  // A conductor without a successor touches none of the conductors of earlier rounds. Therefore only those of the
  // previous round can become successors.
  for (int now = 1; !latest.empty(); ++now) {
    std::vector<int> found;
    for (const int j : latest)
      for (const int i : graph.neighbours[j]) {
        if (successor[i] == unconnected) {
          successor[i] = j;
          round[i] = now;
          found.push_back(i);
        } else if (round[i] == now && distance2(i, j) < distance2(i, successor[i])) {
          successor[i] = j;
        }
      }
    std::sort(found.begin(), found.end());  // the first of equally near ones is then that of smallest index
    latest = std::move(found);
  }
  return successor;
}

template <int d>
ContactNetwork network_of(std::vector<Edge> contacts, std::span<const Vec<d>> position) {
  ContactNetwork result;
  result.contacts = std::move(contacts);
  const ContactGraph graph = contact_graph(static_cast<int>(position.size()), result.contacts);
  result.successor = successors(graph, position);
  result.degrees = degree_distribution(graph, result.successor);
  return result;
}

}  // namespace

std::vector<int> successors(const ContactGraph& graph, std::span<const Vec3> position) {
  return nearest_successors(graph, position);
}
std::vector<int> successors(const ContactGraph& graph, std::span<const Vec2> position) {
  return nearest_successors(graph, position);
}

int DegreeDistribution::branch_points() const {
  return number.size() > 3 ? std::accumulate(number.begin() + 3, number.end(), 0) : 0;
}

double DegreeDistribution::fraction(int degree) const {
  const bool any = degree >= 0 && degree < static_cast<int>(number.size()) && connected > 0;
  return any ? static_cast<double>(number[degree]) / connected : 0;
}

double DegreeDistribution::branching() const {
  return connected > 0 ? static_cast<double>(branch_points()) / connected : 0;
}

DegreeDistribution degree_distribution(const ContactGraph& graph, std::span<const int> successor) {
  DegreeDistribution result;
  int twice_the_contacts = 0;  // contacts between conductors, counted twice
  for (size_t i = 0; i < successor.size(); ++i) {
    if (successor[i] == unconnected) continue;
    const size_t degree = graph.neighbours[i].size() + (graph.grounded[i] ? 1 : 0);
    if (degree >= result.number.size()) result.number.resize(degree + 1);
    ++result.number[degree];
    ++result.connected;
    result.grounded += graph.grounded[i];
    twice_the_contacts += static_cast<int>(graph.neighbours[i].size());
  }
  result.loops = twice_the_contacts / 2 + result.grounded - result.connected;
  return result;
}

DegreeRelations degree_relations(const DegreeDistribution& degrees, int conductors) {
  if (degrees.connected == 0) return {};
  double all = 0, excess = 0, above_3 = 0, above_4 = 0;
  for (int j = 0; j < static_cast<int>(degrees.number.size()); ++j) {
    const double f = degrees.fraction(j);
    all += f;
    excess += (j - 2) * f;
    if (j > 4) above_3 += (j - 3) * f, above_4 += (j - 4) * f;
  }
  const double c = static_cast<double>(2 * degrees.loops - degrees.grounded) / degrees.connected;
  const double f1 = degrees.fraction(1), f3 = degrees.fraction(3), f4 = degrees.fraction(4), b = degrees.branching();
  return {.normalization = all - 1,
          .branches = excess - c,
          .branches_printed = excess + 1.0 / conductors,
          .mean_degree = excess + 2 * (all - 1) - c,
          .mean_degree_printed = excess + 2 * (all - 1),
          .f3 = f3 - (2 * b - f1 - c + above_4),
          .f3_printed = f3 - (2 * b - f1),
          .f4 = f4 - (f1 - b + c - above_3),
          .f4_printed = f4 - (f1 - b)};
}

ContactNetwork network(std::vector<Edge> contacts, std::span<const Vec3> position) {
  return network_of(std::move(contacts), position);
}
ContactNetwork network(std::vector<Edge> contacts, std::span<const Vec2> position) {
  return network_of(std::move(contacts), position);
}

void add_columns(const ContactNetwork& network, Frame& frame) {
  std::vector<std::int32_t> pairs;
  for (const auto& [i, j] : network.contacts) pairs.insert(pairs.end(), {i, j});
  frame.add_list("contacts", "1", std::move(pairs), 2);
  frame.add_particles("successor", "1", std::vector<std::int32_t>(network.successor.begin(), network.successor.end()));
  frame.add_system<std::int64_t>("connected", "1", network.degrees.connected);
  frame.add_system<std::int64_t>("endpoints", "1", network.degrees.endpoints());
  frame.add_system<std::int64_t>("branch_points", "1", network.degrees.branch_points());
}

}  // namespace lichtenberg::analysis
