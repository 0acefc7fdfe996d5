// Euclidean minimum spanning trees of random points (D 7.4.1, figure 7.5), as JSON. The output holds one tree in [-1,
// 1] x [-1, 1] for a picture, and the degrees of many trees. Points are uniform, or have a minimum distance like
// spheres.
//
//   spanning_tree

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include <fmt/format.h>

#include "src/analysis/spanning_tree.hpp"
#include "src/scene/placing.hpp"

using namespace lichtenberg;

namespace {

/// Returns random points (D 7.4.1) with a minimum distance of `distance`, by random sequential addition.
std::vector<Vec2> random_points(int n, double distance, UniformRandom& random) {
  std::vector<Vec2> point;
  while (static_cast<int>(point.size()) < n) {
    const Vec2 p{random.between(-1, 1), random.between(-1, 1)};
    const auto too_near = [&](Vec2 q) { return norm(p - q) < distance; };
    if (distance == 0 || std::ranges::none_of(point, too_near)) point.push_back(p);
  }
  return point;
}

/// Returns the fractions of nodes by degree, with the standard errors of their means over the trees.
nlohmann::ordered_json degrees(int n, int trees, double distance, UniformRandom& random) {
  std::vector<double> sum(7), squares(7);
  for (int k = 0; k < trees; ++k) {
    const std::vector<Vec2> point = random_points(n, distance, random);
    std::vector<int> number = analysis::degree_numbers(n, analysis::euclidean_minimum_spanning_tree(point));
    number.resize(sum.size());
    for (std::size_t j = 0; j < sum.size(); ++j) {
      const double fraction = static_cast<double>(number[j]) / n;
      sum[j] += fraction, squares[j] += fraction * fraction;
    }
  }
  std::vector<double> mean, error;
  for (std::size_t j = 0; j < sum.size(); ++j) {
    mean.push_back(sum[j] / trees);
    error.push_back(std::sqrt(std::max(0.0, squares[j] / trees - mean[j] * mean[j]) / (trees - 1)));
  }
  return {{"nodes", n}, {"trees", trees}, {"distance", distance}, {"fraction", mean}, {"error", error}};
}

}  // namespace

int main() {
  constexpr int nodes = 324;  // as in the source's runs
  // 324 spheres of .775 mm radius, at least 0.1 mm apart, in a box of 51.2 mm, which has width 2 here.
  constexpr double distance = (2 * 0.775 + 0.1) * 2 / 51.2;
  UniformRandom random(1);
  const std::vector<Vec2> point = random_points(nodes, 0, random);
  nlohmann::ordered_json json;
  for (const Vec2 p : point) json["points"].push_back({p.x, p.y});
  json["edges"] = analysis::euclidean_minimum_spanning_tree(point);
  json["uniform"] = degrees(nodes, 2000, 0, random);
  json["many"] = degrees(100000, 10, 0, random);
  json["spheres"] = degrees(nodes, 2000, distance, random);
  fmt::print("{}\n", json.dump());
}
