#include "src/analysis/topology.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace lichtenberg::analysis {
namespace {

/// Returns the quantile of a sorted sample for this fraction.
double quantile(const std::vector<double>& sorted, double fraction) {
  const double at = fraction * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return std::lerp(sorted[below], sorted[above], at - static_cast<double>(below));
}

int nearest_to_ground(std::span<const Vec2> position, std::span<const double> radius, const Ground& ground) {
  std::vector<double> gaps;
  for (std::size_t i = 0; i < position.size(); ++i) gaps.push_back(gap(Disk{position[i], radius[i]}, ground));
  return static_cast<int>(std::ranges::min_element(gaps) - gaps.begin());
}

/// Returns the tree as successors that lead to `root`, whose successor is the ground.
std::vector<int> directed_to(int root, std::span<const Edge> edges, std::span<const Vec2> position) {
  std::vector<Edge> contacts(edges.begin(), edges.end());
  contacts.emplace_back(root, to_ground);
  return successors(contact_graph(static_cast<int>(position.size()), contacts), position);
}

/// Returns the edges of A between conductors as line segments.
std::vector<Segment> tree_lines(std::span<const int> successor, std::span<const Vec2> position) {
  std::vector<Segment> lines;
  for (std::size_t i = 0; i < successor.size(); ++i)
    if (successor[i] >= 0) lines.emplace_back(position[i], position[successor[i]]);
  return lines;
}

double extent(std::span<const Vec2> points) {
  const auto width = [&](double Vec2::*axis) {
    const auto [low, high] = std::ranges::minmax(points, {}, axis);
    return high.*axis - low.*axis;
  };
  return points.empty() ? 0 : std::max(width(&Vec2::x), width(&Vec2::y));
}

}  // namespace

Distribution distribution(std::vector<double> sample) {
  if (sample.empty()) return {};
  std::ranges::sort(sample);
  const auto n = static_cast<double>(sample.size());
  const double mean = std::accumulate(sample.begin(), sample.end(), 0.0) / n;
  double squares = 0;
  for (const double x : sample) squares += (x - mean) * (x - mean);
  return {.count = static_cast<int>(sample.size()),
          .least = sample.front(),
          .quarter = quantile(sample, 0.25),
          .median = quantile(sample, 0.5),
          .three_quarters = quantile(sample, 0.75),
          .largest = sample.back(),
          .mean = mean,
          .deviation = n > 1 ? std::sqrt(squares / (n - 1)) : 0};
}

std::vector<Vec2> xy_projection(std::span<const Vec3> position) {
  std::vector<Vec2> seen;
  for (const Vec3 p : position) seen.push_back(plane(p));
  return seen;
}

SpanningTree spanning_tree(std::span<const Vec2> position, std::span<const double> radius,
                           std::span<const int> successor, const Ground& ground) {
  SpanningTree tree;
  if (position.empty()) return tree;
  tree.edges = euclidean_minimum_spanning_tree(position);
  tree.number = degree_numbers(static_cast<int>(position.size()), tree.edges);
  tree.length = total_length(position, tree.edges);
  const std::vector<int> next = directed_to(nearest_to_ground(position, radius, ground), tree.edges, position);
  tree.strahler = strahler_distribution(next, strahler_numbers(next));
  for (const auto& [a, b] : tree.edges) tree.shared += successor[a] == b || successor[b] == a;
  return tree;
}

Topology topology(ContactNetwork network, std::span<const Vec2> position, std::span<const double> radius,
                  const Ground& ground) {
  Topology result;
  result.relations = degree_relations(network.degrees, static_cast<int>(position.size()));
  result.strahler = strahler_numbers(network.successor);
  result.orders = strahler_distribution(network.successor, result.strahler);

  const std::vector<Segment> lines = tree_lines(network.successor, position);
  std::vector<double> length;
  for (const auto& [a, b] : lines) length.push_back(norm(a - b));
  result.tree_length = std::accumulate(length.begin(), length.end(), 0.0);
  result.edge_length = distribution(std::move(length));

  std::vector<Vec2> connected;
  for (std::size_t i = 0; i < position.size(); ++i)
    if (network.successor[i] != unconnected) connected.push_back(position[i]);
  const double shortest = 2 * result.edge_length.mean, size = extent(connected);
  result.boxes = box_counting_dimension(lines, shortest, size / 2);
  result.masses = mass_radius_dimension(connected, shortest, size / 4);

  result.minimum = spanning_tree(position, radius, network.successor, ground);
  result.network = std::move(network);
  return result;
}

}  // namespace lichtenberg::analysis
