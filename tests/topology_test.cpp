// Tests of global properties of a tree: Strahler numbers, degree relations, dimensions, statistics of edges.
#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "src/analysis/topology.hpp"

namespace topology_test {

using namespace lichtenberg;
using namespace lichtenberg::analysis;

namespace {

constexpr double exact = 1e-12;  // Sums of a few fractions of order 1, with rounding errors of 1e-16.

/// Conductors of radius 1 with contact gap 1 in a box of 100, with a grounded bottom side.
const Ground bottom{{100, 100}, {false, false, true, false}, {}};

Topology topology_of(const std::vector<Vec2>& position) {
  const std::vector<double> radius(position.size(), 1.0);
  return topology(analysis::network(contacts(position, radius, 1.0, bottom), position), position, radius, bottom);
}

/// Successors of the perfect binary tree with the given number of levels: i is attached to (i - 1) / 2, and 0 to the
/// ground.
std::vector<int> binary_tree(int levels) {
  std::vector<int> successor{to_ground};
  for (int i = 1; i < (1 << levels) - 1; ++i) successor.push_back((i - 1) / 2);
  return successor;
}

void check_general_relations(const DegreeRelations& r) {
  for (const double residual : {r.normalization, r.branches, r.mean_degree, r.f3, r.f4})
    CHECK_EQ(residual, doctest::Approx(0).epsilon(exact));
}

}  // namespace

TEST_CASE("Strahler numbers: count the levels of a perfect binary tree") {
  const std::vector<int> successor = binary_tree(5), number = strahler_numbers(successor);
  for (int i = 0; i < 31; ++i) CHECK_EQ(number[i], 5 - static_cast<int>(std::log2(i + 1)));
  const StrahlerDistribution orders = strahler_distribution(successor, number);
  CHECK_EQ(orders.highest(), 5);
  CHECK_EQ(orders.conductors, std::vector<int>{0, 16, 8, 4, 2, 1});
  CHECK_EQ(orders.streams, orders.conductors);
  for (int j = 1; j < 5; ++j) {
    CHECK_EQ(orders.bifurcation_ratio(j), 2);
    CHECK_EQ(orders.stream_length(j), 1);
  }
}

TEST_CASE("Strahler numbers: a chain has number 1 and is one stream") {
  const std::vector<int> successor{to_ground, 0, 1, 2, 3}, number = strahler_numbers(successor);
  CHECK_EQ(number, std::vector<int>(5, 1));
  const StrahlerDistribution orders = strahler_distribution(successor, number);
  CHECK_EQ(orders.streams, std::vector<int>{0, 1});
  CHECK_EQ(orders.stream_length(1), 5);
}

TEST_CASE("Strahler numbers: two equal largest branches raise the number by one") {
  // 0 (ground) <- 1 <- 2, 3, 4 (tips): 1 has three tips and number 2. 0 <- 5 (tip): 0 keeps number 2.
  CHECK_EQ(strahler_numbers(std::vector<int>{to_ground, 0, 1, 1, 1, 0}), std::vector<int>{2, 2, 1, 1, 1, 1});
  // The larger branch comes before or after two equal smaller ones: 1 is of order 2, and the tips 4 to 6 are also
  // attached to 0.
  CHECK_EQ(strahler_numbers(std::vector<int>{to_ground, 0, 1, 1, 0, 0, 0})[0], 2);
  CHECK_EQ(strahler_numbers(std::vector<int>{5, 5, 5, 4, 5, to_ground, 3, 3})[5], 2);
  // A stream of order 2 with a side tip continues as one stream of three.
  const std::vector<int> stream{to_ground, 0, 1, 2, 2, 1};
  const auto number = strahler_numbers(stream);
  CHECK_EQ(number, std::vector<int>{2, 2, 2, 1, 1, 1});
  CHECK_EQ(strahler_distribution(stream, number).streams, std::vector<int>{0, 3, 1});
}

TEST_CASE("Strahler numbers of two trees: separate, zero for unconnected conductors") {
  const std::vector<int> two{to_ground, to_ground, unconnected, 1, 1};
  CHECK_EQ(strahler_numbers(two), std::vector<int>{1, 2, 0, 1, 1});
  CHECK_EQ(strahler_distribution(two, strahler_numbers(two)).conductors, std::vector<int>{0, 3, 1});
  CHECK(strahler_numbers({}).empty());
  CHECK_EQ(strahler_distribution({}, {}).highest(), 0);
}

TEST_CASE("ring of conductors: all have Strahler number 1, none has degree 1") {
  // A square of side 2.5 on the ground: 0 and 1 below, 2 and 3 on top; 2 and 3 touch.
  const Topology t = topology_of({{10, 1.5}, {12.5, 1.5}, {10, 4}, {12.5, 4}});
  CHECK_EQ(t.network.degrees.number, std::vector<int>{0, 0, 2, 2});
  CHECK_EQ(t.network.degrees.loops, 2);
  CHECK_EQ(t.strahler, std::vector<int>{1, 1, 1, 1});
  check_general_relations(t.relations);
  CHECK_EQ(t.relations.mean_degree_printed, doctest::Approx(0.5).epsilon(exact));  // (2 + 2 + 3 + 3) / 4 - 2
}

TEST_CASE("node degree relations, M conductors: corrected hold, printed lack 1/M") {
  // A stem of three conductors with three arms, and one isolated conductor.
  const std::vector<Vec2> one_foot{{10, 1.5}, {10, 4}, {10, 6.5}, {12.5, 6.5}, {7.5, 6.5}, {10, 9}, {50, 50}};
  const Topology tree = topology_of(one_foot);
  CHECK_EQ(tree.network.degrees.connected, 6);
  check_general_relations(tree.relations);
  // c = -1/6, and 7.7 has N = 7 instead of M = 6.
  CHECK_EQ(tree.relations.branches_printed, doctest::Approx(-1. / 6 + 1. / 7).epsilon(exact));
  CHECK_EQ(tree.relations.mean_degree_printed, doctest::Approx(-1. / 6).epsilon(exact));
  CHECK_EQ(tree.relations.f3_printed, doctest::Approx(1. / 6).epsilon(exact));
  CHECK_EQ(tree.relations.f4_printed, doctest::Approx(-1. / 6).epsilon(exact));
  // Two conductors on the ground: c = -2/2. Each of the two has degree 1.
  const Topology posts = topology_of({{10, 1.5}, {20, 1.5}});
  check_general_relations(posts.relations);
  CHECK_EQ(posts.relations.branches_printed, doctest::Approx(-1 + 0.5).epsilon(exact));
  // Without connected conductors all values are zero.
  const Topology none = topology_of({{50, 50}});
  CHECK_EQ(none.relations.normalization, 0);
  CHECK_EQ(none.relations.branches_printed, 0);
}

TEST_CASE("node degree relations: hold for degrees above 4 as well") {
  // Nine conductors on a circle of radius 2.95 around one. The centres are 2.95 * 2 sin 20 = 2.018 apart: none overlap,
  // and all neighbours touch each other. The ground is below the lowest.
  std::vector<Vec2> flower{{20, 4.5}};
  for (int k = 0; k < 9; ++k)
    flower.push_back(flower[0] + 2.95 * Vec2{std::sin(2 * M_PI * k / 9), -std::cos(2 * M_PI * k / 9)});
  const Topology t = topology_of(flower);
  REQUIRE_EQ(t.network.degrees.number.size(), 10);
  CHECK_EQ(t.network.degrees.number[9], 1);
  check_general_relations(t.relations);
}

TEST_CASE("distribution: quartiles, extremes, mean and deviation of a sample") {
  const Distribution d = distribution({4, 1, 3, 2});
  CHECK_EQ(d.count, 4);
  CHECK_EQ(d.least, 1);
  CHECK_EQ(d.quarter, 1.75);
  CHECK_EQ(d.median, 2.5);
  CHECK_EQ(d.three_quarters, 3.25);
  CHECK_EQ(d.largest, 4);
  CHECK_EQ(d.mean, 2.5);
  CHECK_EQ(d.deviation, doctest::Approx(std::sqrt(5. / 3)));
  CHECK_EQ(distribution({7}).median, 7);
  CHECK_EQ(distribution({7}).deviation, 0);
  CHECK_EQ(distribution({}).count, 0);
}

TEST_CASE("topology: known lengths of the tree and the minimum spanning tree") {
  // 0 is on the ground, 1 on 0, 2 next to 1 with a link of 2.9. 3 is isolated, at a distance of 5 from 2.
  const Topology t = topology_of({{10, 1.5}, {10, 4}, {12.9, 4}, {17.9, 4}});
  CHECK_EQ(t.edge_length.count, 2);
  CHECK_EQ(t.edge_length.least, 2.5);
  CHECK_EQ(t.edge_length.largest, doctest::Approx(2.9));
  CHECK_EQ(t.tree_length, doctest::Approx(5.4));
  CHECK_EQ(t.minimum.edges.size(), 3);
  CHECK_EQ(t.minimum.length, doctest::Approx(10.4));
  CHECK_EQ(t.minimum.shared, 2);
  CHECK_EQ(t.minimum.number, std::vector<int>{0, 2, 2});
  CHECK_EQ(t.minimum.strahler.conductors, std::vector<int>{0, 4});  // A chain from the ground.
  CHECK_FALSE(t.boxes.has_value());                                 // The tree is 2.9 wide, and one line below 5.4.
  CHECK_FALSE(t.masses.has_value());
}

TEST_CASE("topology without conductors: empty and no error") {
  const Topology t = topology_of({});
  CHECK_EQ(t.network.degrees.connected, 0);
  CHECK_EQ(t.edge_length.count, 0);
  CHECK_FALSE(t.boxes.has_value());
  CHECK(t.minimum.edges.empty());
}

TEST_CASE("fit_power_law: finds exponent, standard error and range") {
  std::vector<double> x, y;
  for (int k = 0; k < 10; ++k) x.push_back(std::pow(2, k)), y.push_back(3 * std::pow(x.back(), -1.5));
  const PowerLaw law = fit_power_law(x, y);
  CHECK_EQ(law.exponent, doctest::Approx(-1.5));
  CHECK_LT(law.standard_error, 1e-7);  // The square root of rounding.
  CHECK_EQ(law.from, 1);
  CHECK_EQ(law.to, 512);
  CHECK_EQ(law.points, 10);
  // log y = 0, 1, 0 at log x = -1, 0, 1: the slope is 0 and the residuals are -1/3, 2/3, -1/3. Hence s^2 = (6/9) / 1,
  // and the error is s / sqrt(2).
  const std::vector<double> e{std::exp(-1.0), 1, std::exp(1.0)}, bump{1, std::exp(1.0), 1};
  CHECK_EQ(fit_power_law(e, bump).standard_error, doctest::Approx(std::sqrt(1. / 3)));
}

TEST_CASE("fractal dimensions: known for a line, a plane and Vicsek's cross") {
  std::vector<analysis::Segment> line{{{0.1, 0.2}, {64.1, 0.2}}}, grid, cross;
  std::vector<Vec2> on_line, on_plane;
  for (int i = 0; i < 2000; ++i) on_line.push_back({i * 0.08, i * 0.06});
  for (int i = 0; i < 64; ++i) {
    grid.push_back({{static_cast<double>(i), 0}, {static_cast<double>(i), 63}});
    for (int j = 0; j < 64; ++j) on_plane.push_back({static_cast<double>(i), static_cast<double>(j)});
  }
  // Boxes of side s on a line of 64: 64 / s or one more; no scale is large.
  CHECK_EQ(box_counting_dimension(line, 0.5, 8)->exponent, doctest::Approx(1).epsilon(0.02));
  // Lines at distance 1: every box of side 2 or more contains a part. The ceil(63 / s)^2 boxes scatter about s^-2.
  CHECK_EQ(box_counting_dimension(grid, 2, 16)->exponent, doctest::Approx(2).epsilon(0.05));
  // Points at distance 0.1 on a line of 200. Within r there are 2 r / 0.1 others minus those beyond the ends, on
  // average r / 200 of them. This changes the slope by half of 10 / 200. Counts are integers of at least 20.
  CHECK_EQ(mass_radius_dimension(on_line, 1, 10)->exponent, doctest::Approx(1).epsilon(0.05));
  // A square of side a lacks (8/3 pi) r / a of the neighbours within r. The slope is 2 - 0.85 r / (a - 0.85 r), on
  // average over 2 to 8 of 64 about 0.06 less than 2. The lattice's steps scatter by as much.
  const double plane = mass_radius_dimension(on_plane, 2, 8)->exponent;
  CHECK_GT(plane, 1.85);
  CHECK_LT(plane, 2.0);

  // Five copies at 1/3 of the size, four times: D = log 5 / log 3 = 1.465. The segments run from the centre to the four
  // corners of its cells. Scales of powers of 1/3 would give it exactly; others scatter.
  std::vector<Vec2> centre{{0.5, 0.5}};
  double side = 1;
  for (int level = 0; level < 5; ++level) {
    side /= 3;
    std::vector<Vec2> next;
    for (const Vec2 c : centre)
      for (const Vec2 step : {Vec2{0, 0}, Vec2{1, 1}, Vec2{1, -1}, Vec2{-1, 1}, Vec2{-1, -1}})
        next.push_back(c + side * step);
    centre = next;
  }
  for (const Vec2 c : centre) cross.push_back({c, c + side * Vec2{0.1, 0.05}});
  const double vicsek = std::log(5) / std::log(3);
  CHECK_EQ(box_counting_dimension(cross, 2 * side, 2 * side * 81)->exponent, doctest::Approx(vicsek).epsilon(0.05));
  CHECK_EQ(mass_radius_dimension(centre, 2 * side, 2 * side * 27)->exponent, doctest::Approx(vicsek).epsilon(0.05));
}

TEST_CASE("fractal dimensions: none if scales differ by less than a factor of two") {
  const std::vector<analysis::Segment> line{{{0, 0}, {1, 0}}};
  const std::vector<Vec2> point{{0, 0}, {1, 0}, {2, 0}};
  CHECK_FALSE(box_counting_dimension(line, 1, 1.9).has_value());
  CHECK_FALSE(box_counting_dimension(line, 0, 1).has_value());
  CHECK_FALSE(box_counting_dimension({}, 1, 4).has_value());
  CHECK_FALSE(mass_radius_dimension(point, 0.1, 0.5).has_value());  // There is no point within this distance.
  CHECK(mass_radius_dimension(point, 1, 2).has_value());
}

}  // namespace topology_test
