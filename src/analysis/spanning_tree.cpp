#include "src/analysis/spanning_tree.hpp"

#include <algorithm>
#include <boost/polygon/voronoi.hpp>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "solvers/disjoint_sets.hpp"
#include "solvers/error.hpp"

namespace lichtenberg::analysis {
namespace {

using Site = boost::polygon::point_data<std::int32_t>;

/// Rounds the points to a lattice of 2^30 sites, so that sums and differences of coordinates are exact in 32 bits.
std::vector<Site> on_lattice(std::span<const Vec2> point) {
  constexpr double sites = 1 << 30;
  Vec2 low = point.front(), high = low;
  for (const Vec2 p : point) {
    if (!std::isfinite(p.x) || !std::isfinite(p.y))
      throw InputError("a point of the spanning tree has a coordinate that is not finite");
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }
  const double extent = std::max(high.x - low.x, high.y - low.y);
  const double scale = extent > 0 ? sites / extent : 0;
  std::vector<Site> result;
  result.reserve(point.size());
  for (const Vec2 p : point)
    result.emplace_back(static_cast<std::int32_t>(std::lround((p.x - low.x) * scale)),
                        static_cast<std::int32_t>(std::lround((p.y - low.y) * scale)));
  return result;
}

Edge edge_of(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

/// Returns the first point of each site, ordered by site, and appends an edge to it from each other point of the site.
std::vector<int> first_of_each_site(const std::vector<Site>& site, std::vector<Edge>& edges) {
  std::vector<int> order(site.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, [&](int a, int b) { return site[a] == site[b] ? a < b : site[a] < site[b]; });
  std::vector<int> first;
  for (const int i : order) {
    if (first.empty() || !(site[first.back()] == site[i]))
      first.push_back(i);
    else
      edges.push_back(edge_of(first.back(), i));
  }
  return first;
}

}  // namespace

std::vector<Edge> delaunay_edges(std::span<const Vec2> point) {
  std::vector<Edge> edges;
  if (point.empty()) return edges;
  const std::vector<Site> site = on_lattice(point);
  const std::vector<int> index = first_of_each_site(site, edges);
  std::vector<Site> distinct;
  distinct.reserve(index.size());
  for (const int i : index) distinct.push_back(site[i]);
  // The Delaunay triangulation is the dual of the Voronoi diagram: each Voronoi edge separates two points.
  boost::polygon::voronoi_diagram<double> diagram;
  boost::polygon::construct_voronoi(distinct.begin(), distinct.end(), &diagram);
  for (const auto& side : diagram.edges()) {
    const int a = index[side.cell()->source_index()], b = index[side.twin()->cell()->source_index()];
    if (a < b) edges.emplace_back(a, b);  // the twin has them in reverse order
  }
  std::ranges::sort(edges);
  return edges;
}

std::vector<Edge> minimum_spanning_forest(int nodes, std::span<const Edge> edge, std::span<const double> weight) {
  std::vector<int> order(edge.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order,
                    [&](int a, int b) { return weight[a] == weight[b] ? edge[a] < edge[b] : weight[a] < weight[b]; });
  DisjointSets sets(nodes);
  std::vector<Edge> forest;
  for (const int k : order)
    if (sets.unite(edge[k].first, edge[k].second)) forest.push_back(edge[k]);
  return forest;
}

std::vector<Edge> euclidean_minimum_spanning_tree(std::span<const Vec2> point) {
  const std::vector<Edge> edges = delaunay_edges(point);
  std::vector<double> length;
  length.reserve(edges.size());
  for (const auto& [a, b] : edges) length.push_back(norm(point[a] - point[b]));
  return minimum_spanning_forest(static_cast<int>(point.size()), edges, length);
}

std::vector<int> degree_numbers(int nodes, std::span<const Edge> edge) {
  std::vector<int> degree(nodes);
  for (const auto& [a, b] : edge) ++degree[a], ++degree[b];
  std::vector<int> number(nodes == 0 ? 0 : *std::ranges::max_element(degree) + 1);
  for (const int d : degree) ++number[d];
  return number;
}

double total_length(std::span<const Vec2> point, std::span<const Edge> edge) {
  double sum = 0;
  for (const auto& [a, b] : edge) sum += norm(point[a] - point[b]);
  return sum;
}

}  // namespace lichtenberg::analysis
