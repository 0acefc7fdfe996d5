#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>
#include <vector>

#include "src/analysis/network.hpp"
#include "src/analysis/spanning_tree.hpp"
#include "src/analysis/strahler.hpp"
#include "src/scene/placing.hpp"

/// Random points in the unit square, and their minimum spanning trees on a torus. A torus has no boundary, so results
/// equal the limit of many points up to terms of 1/N.
namespace lichtenberg::validation {

/// Draws n uniformly distributed points in the unit square.
inline std::vector<Vec2> uniform_points(int n, UniformRandom& random) {
  std::vector<Vec2> point(n);
  for (Vec2& p : point) p = {random(), random()};
  return point;
}

/// Computes the shortest vector from a to b on the unit torus (minimum image).
inline Vec2 on_torus(Vec2 a, Vec2 b) {
  const Vec2 d = b - a;
  return {d.x - std::round(d.x), d.y - std::round(d.y)};
}

/// Draws n points of the unit torus that are at least `distance` apart, by random sequential addition. Throws
/// std::runtime_error if too many trials fail.
inline std::vector<Vec2> hard_core_points(int n, double distance, UniformRandom& random) {
  const int columns = static_cast<int>(1 / distance);  // cells at least as wide as the distance
  std::vector<std::vector<Vec2>> cell(static_cast<std::size_t>(columns) * columns);
  const auto at = [&](int x, int y) -> std::vector<Vec2>& {
    return cell[static_cast<std::size_t>((y + columns) % columns) * columns + (x + columns) % columns];
  };
  const auto free = [&](Vec2 p, int x, int y) {
    for (int i = x - 1; i <= x + 1; ++i)
      for (int j = y - 1; j <= y + 1; ++j)
        for (const Vec2 q : at(i, j))
          if (norm2(on_torus(p, q)) < distance * distance) return false;
    return true;
  };
  std::vector<Vec2> point;
  for (long tries = 0; static_cast<int>(point.size()) < n; ++tries) {
    if (tries > 1000L * n) throw std::runtime_error("hard-core points: too dense for random sequential addition");
    const Vec2 p{random(), random()};
    const int x = static_cast<int>(p.x * columns), y = static_cast<int>(p.y * columns);
    if (!free(p, x, y)) continue;
    at(x, y).push_back(p);
    point.push_back(p);
  }
  return point;
}

/// Delaunay triangulation of points on the unit torus, with the edges' lengths.
struct TorusTriangulation {
  std::vector<analysis::Edge> edge;
  std::vector<double> length;
};

/// Computes the Delaunay triangulation of points on the unit torus, by triangulation of the points and their periodic
/// images in a margin around the square. The margin is eight mean spacings wide, four times the radius of the largest
/// empty circle among a million random points. All triangles at the square's edge are therefore correct.
inline TorusTriangulation triangulate_on_torus(const std::vector<Vec2>& point) {
  const int n = static_cast<int>(point.size());
  const double margin = std::min(0.5, 8 / std::sqrt(n));
  std::vector<Vec2> with_images = point;
  std::vector<int> original(n);
  for (int i = 0; i < n; ++i) original[i] = i;
  for (int i = 0; i < n; ++i)
    for (double dx = -1; dx <= 1; ++dx)
      for (double dy = -1; dy <= 1; ++dy) {
        const Vec2 image = point[i] + Vec2{dx, dy};
        const bool near = std::abs(image.x - 0.5) <= 0.5 + margin && std::abs(image.y - 0.5) <= 0.5 + margin;
        if ((dx == 0 && dy == 0) || !near) continue;
        with_images.push_back(image);
        original.push_back(i);
      }
  TorusTriangulation result;
  for (const auto& [a, b] : analysis::delaunay_edges(with_images))
    if (a < n) result.edge.emplace_back(std::minmax(original[a], original[b]));  // a < b: the first one is no image
  std::ranges::sort(result.edge);  // edges across the square's sides occur twice
  result.edge.erase(std::unique(result.edge.begin(), result.edge.end()), result.edge.end());
  for (const auto& [a, b] : result.edge) result.length.push_back(norm(on_torus(point[a], point[b])));
  return result;
}

/// Computes the Euclidean minimum spanning tree from a triangulation.
inline std::vector<analysis::Edge> spanning_tree_on_torus(int points, const TorusTriangulation& triangulation) {
  return analysis::minimum_spanning_forest(points, triangulation.edge, triangulation.length);
}

/// Accumulator of the mean over independent samples, with its standard error.
class Mean {
 public:
  void add(double x) { ++count_, sum_ += x, squares_ += x * x; }
  double value() const { return sum_ / count_; }
  double error() const {
    return std::sqrt(std::max(0.0, squares_ / count_ - value() * value()) / std::max(1.0, count_ - 1));
  }

 private:
  double count_ = 0, sum_ = 0, squares_ = 0;
};

/// Statistics of a sample of trees, as fractions of the number of nodes: nodes by degree, nodes by Strahler number, and
/// streams by Strahler number.
struct TreeFractions {
  std::vector<Mean> degree = std::vector<Mean>(7), strahler = std::vector<Mean>(7), streams = std::vector<Mean>(7);

  /// Adds a tree by its numbers of nodes of each degree and its distribution of Strahler numbers.
  void add(const std::vector<int>& degree_number, const analysis::StrahlerDistribution& orders, int nodes) {
    const auto add_all = [&](std::vector<Mean>& means, const std::vector<int>& number) {
      for (std::size_t j = 0; j < means.size(); ++j)
        means[j].add(j < number.size() ? static_cast<double>(number[j]) / nodes : 0);
    };
    add_all(degree, degree_number);
    add_all(strahler, orders.conductors);
    add_all(streams, orders.streams);
  }

  /// Adds a spanning tree of points, with its first node as the root.
  void add(const std::vector<analysis::Edge>& tree, std::span<const Vec2> point) {
    const int nodes = static_cast<int>(point.size());
    std::vector<analysis::Edge> contacts(tree.begin(), tree.end());
    contacts.emplace_back(0, analysis::to_ground);
    const std::vector<int> next = analysis::successors(analysis::contact_graph(nodes, contacts), point);
    add(analysis::degree_numbers(nodes, tree), analysis::strahler_distribution(next, analysis::strahler_numbers(next)),
        nodes);
  }
};

}  // namespace lichtenberg::validation
