// Tests of Euclidean minimum spanning trees against Prim's algorithm on all pairs, and for degenerate points.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "solvers/error.hpp"
#include "src/analysis/spanning_tree.hpp"

namespace spanning_tree_test {

using namespace lichtenberg;
using namespace lichtenberg::analysis;

namespace {

/// Prim's algorithm on all pairs.
std::vector<Edge> by_prim(const std::vector<Vec2>& point) {
  const int n = static_cast<int>(point.size());
  std::vector<double> distance(n, std::numeric_limits<double>::infinity());
  std::vector<int> nearest(n, 0);
  std::vector<bool> in_tree(n);
  std::vector<Edge> tree;
  for (int latest = 0, k = 1; k < n; ++k) {
    in_tree[latest] = true;
    int next = -1;
    for (int i = 0; i < n; ++i) {
      if (in_tree[i]) continue;
      const double d = norm(point[i] - point[latest]);
      if (d < distance[i]) distance[i] = d, nearest[i] = latest;
      if (next < 0 || distance[i] < distance[next]) next = i;
    }
    tree.emplace_back(std::min(next, nearest[next]), std::max(next, nearest[next]));
    latest = next;
  }
  return tree;
}

std::vector<Edge> sorted(std::vector<Edge> edges) {
  std::ranges::sort(edges);
  return edges;
}

std::vector<Vec2> random_points(int n, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Vec2> point(n);
  for (Vec2& p : point) p = {uniform(random), uniform(random)};
  return point;
}

/// Checks that the spanning tree has the minimum length, within rounding of the sum of n lengths and of the lattice
/// (4e-9 per edge).
void check_shortest(const std::vector<Vec2>& point) {
  const auto tree = euclidean_minimum_spanning_tree(point);
  REQUIRE_EQ(tree.size(), point.size() - 1);
  const auto forest = minimum_spanning_forest(static_cast<int>(point.size()), tree, std::vector<double>(tree.size()));
  CHECK_EQ(forest.size(), tree.size());  // Without a loop it is a spanning tree.
  double extent = 0;
  for (const Vec2 p : point) extent = std::max({extent, std::abs(p.x - point[0].x), std::abs(p.y - point[0].y)});
  const double shortest = total_length(point, by_prim(point));
  CHECK_LE(total_length(point, tree), shortest * (1 + 1e-12) + 4e-9 * extent * static_cast<double>(tree.size()));
  CHECK_GE(total_length(point, tree), shortest * (1 - 1e-12));
}

}  // namespace

TEST_CASE("euclidean_minimum_spanning_tree: equals Prim's for random points") {
  for (unsigned seed = 0; seed < 300; ++seed) {
    const auto point = random_points(2 + static_cast<int>(seed) % 60, seed);
    CHECK_EQ(sorted(euclidean_minimum_spanning_tree(point)), sorted(by_prim(point)));
  }
  const auto many = random_points(2000, 1);
  CHECK_EQ(sorted(euclidean_minimum_spanning_tree(many)), sorted(by_prim(many)));
}

TEST_CASE("euclidean_minimum_spanning_tree: none, one and two points") {
  CHECK(euclidean_minimum_spanning_tree({}).empty());
  CHECK(degree_numbers(0, {}).empty());
  const std::vector<Vec2> one{{3, 4}}, two{{3, 4}, {0, 0}};
  CHECK(euclidean_minimum_spanning_tree(one).empty());
  CHECK_EQ(degree_numbers(1, {}), std::vector<int>{1});
  CHECK_EQ(euclidean_minimum_spanning_tree(two), std::vector<Edge>{{0, 1}});
  CHECK_EQ(total_length(two, euclidean_minimum_spanning_tree(two)), 5);
}

TEST_CASE("euclidean_minimum_spanning_tree: joins neighbours on a line") {
  // In shuffled order on lines of all slopes. The gaps differ, so the tree is unique.
  const std::vector<int> order{3, 0, 4, 2, 1, 5};
  for (const Vec2 along : {Vec2{1, 0}, Vec2{0, 1}, Vec2{0.3, 0.7}, Vec2{-2, 1e-6}, Vec2{1. / 3, -1. / 7}}) {
    std::vector<Vec2> point(order.size());
    for (std::size_t k = 0; k < order.size(); ++k) point[order[k]] = (static_cast<double>(k * k) + 1) * along;
    CHECK_EQ(sorted(euclidean_minimum_spanning_tree(point)), sorted(by_prim(point)));
  }
}

TEST_CASE("euclidean_minimum_spanning_tree: shortest for degenerate points") {
  std::vector<Vec2> square, triangular, circle, same(7, Vec2{0.1, 0.2});
  for (int i = 0; i < 20; ++i)
    for (int j = 0; j < 20; ++j) {
      square.push_back({i * 0.1, j * 0.1});
      triangular.push_back({i + 0.5 * j, j * std::sqrt(0.75)});
    }
  for (int i = 0; i < 100; ++i) circle.push_back({std::cos(0.02 * M_PI * i), std::sin(0.02 * M_PI * i)});
  for (const auto& point : {square, triangular, circle, same}) check_shortest(point);
  circle.push_back({0, 0});
  check_shortest(circle);

  std::vector<Vec2> twice = random_points(50, 3);
  twice.insert(twice.end(), twice.begin(), twice.end());
  check_shortest(twice);
  std::vector<Vec2> nearly = twice;  // The points are closer to each other than the lattice's resolution.
  for (std::size_t i = 50; i < 100; ++i) nearly[i] += {1e-13, -1e-13};
  check_shortest(nearly);
  std::vector<Vec2> clusters = random_points(40, 4);  // Two clusters, smaller than their distance by 1e8.
  for (std::size_t i = 0; i < 20; ++i) clusters[i] = 1e-8 * clusters[i] + Vec2{1, 1};
  for (std::size_t i = 20; i < 40; ++i) clusters[i] = 1e-8 * clusters[i];
  check_shortest(clusters);
}

TEST_CASE("spanning tree of a star: its centre has degree five") {
  // Five neighbours at angles of 72 degrees are at 1.18 times their distance from the centre from each other.
  std::vector<Vec2> star{{0, 0}};
  for (int k = 0; k < 5; ++k) star.push_back({std::cos(0.4 * M_PI * k), std::sin(0.4 * M_PI * k)});
  CHECK_EQ(degree_numbers(6, euclidean_minimum_spanning_tree(star)), std::vector<int>{0, 5, 0, 0, 0, 1});
}

TEST_CASE("minimum_spanning_forest: a tree per component, first of equal edges") {
  // 0 -1- 1 -2- 2    3 -1- 4, where 0 - 2 closes a triangle and is a second edge of weight 2.
  const std::vector<Edge> edge{{0, 1}, {1, 2}, {0, 2}, {3, 4}};
  CHECK_EQ(minimum_spanning_forest(5, edge, std::vector<double>{1, 2, 3, 1}),
           std::vector<Edge>{{0, 1}, {3, 4}, {1, 2}});
  CHECK_EQ(minimum_spanning_forest(5, edge, std::vector<double>{1, 2, 2, 1}),
           std::vector<Edge>{{0, 1}, {3, 4}, {0, 2}});
}

TEST_CASE("euclidean_minimum_spanning_tree: a point with a NaN is refused") {
  const std::vector<Vec2> point{{0, 0}, {std::nan(""), 1}};
  CHECK_THROWS_AS(euclidean_minimum_spanning_tree(point), InputError);
}

}  // namespace spanning_tree_test
