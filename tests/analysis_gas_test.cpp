// Tests of statistics of gases of grains, on gases with known properties.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "solvers/random.hpp"
#include "src/analysis/gas_state.hpp"
#include "src/model/neighbours.hpp"

namespace analysis_gas_test {

using namespace lichtenberg;
using namespace lichtenberg::analysis;
using doctest::Approx;

namespace {

Random random_of(std::uint64_t i) { return Random({.seed = 5, .purpose = RandomPurpose::population, .i = i}); }

/// Grains of diameter and mass 1 at rest at the given positions of a periodic cube.
Bodies grains_at(double length, std::vector<Vec3> positions) {
  Bodies b{.dimension = 3};
  for (const Vec3 p : positions) b.position.insert(b.position.end(), {p.x, p.y, p.z});
  b.momentum.assign(3 * positions.size(), 0);
  b.mass.assign(positions.size(), 1);
  b.radius.assign(positions.size(), 0.5);
  b.box.lengths = {length, length, length};
  b.box.sides.fill(Boundary::periodic);
  b.image.assign(3 * positions.size(), 0);
  return b;
}

Bodies random_grains(int n, double length) {
  std::vector<Vec3> positions;
  for (int i = 0; i < n; ++i) {
    Random random = random_of(i);
    positions.push_back({random.uniform(0, length), random.uniform(0, length), random.uniform(0, length)});
  }
  return grains_at(length, positions);
}

/// Sets velocities of temperature T about a flow that depends on the position.
void set_in_motion(Bodies& b, double temperature, const std::function<Vec3(Vec3)>& flow) {
  for (int i = 0; i < b.size(); ++i) {
    Random random = random_of(1'000'000 + i);
    const Vec3 mean = flow(position<3>(b, i));
    for (int k = 0; k < 3; ++k)
      b.momentum[3 * i + k] = b.mass[i] * (mean[k] + std::sqrt(temperature / b.mass[i]) * random.normal());
  }
}

/// Adds n grains around the centre of a cell of edge 2.
void fill(std::vector<Vec3>& positions, Vec3 cell, int n) {
  for (int k = 0; k < n; ++k) positions.push_back(2.0 * cell + Vec3{1 + 0.1 * k, 1, 1});
}

std::vector<double> samples(int n, double (*draw)(Random&)) {
  std::vector<double> values;
  for (int i = 0; i < n; ++i) {
    Random random = random_of(i);
    values.push_back(draw(random));
  }
  return values;
}

}  // namespace

TEST_CASE("averaging cells: a whole number fills the box; neighbours are periodic") {
  const Bodies b = grains_at(10.4, {{0.1, 10.3, 5}, {10.39, 0, 0}});
  const Cells cells = cells_of(b, 2);
  CHECK(cells.count == std::array{5, 5, 5});
  CHECK(cells_of(b, 2.2).count[0] == 5);  // 4.7 rounds to 5.
  CHECK(cells.edge.x == Approx(2.08).epsilon(1e-15).scale(0));
  const OccupiedCells occupied = occupied_cells(b, cells);
  CHECK(occupied.cell == std::vector<std::int64_t>{4, 0 + 5 * 4 + 25 * 2});
  CHECK(occupied.body_cell == std::vector{1, 0});
  CHECK(occupied.find(70) == 1);
  CHECK(occupied.find(5) == -1);
  CHECK(cells.next(4, 0) == 0);
  CHECK(cells.next(4, 1) == 9);
  CHECK(cells.next(20, 1) == 0);
  CHECK(cells.next(124, 2) == 24);
}

TEST_CASE("granular temperature: unbiased in a flow with 2 grains per cell") {
  constexpr double temperature = 0.3;
  // On average there are 2 grains per cell: dividing by n_c instead of n_c - 1 would give a value lower by a fraction
  // of (1 - exp(-2)) / 2 = 0.43.
  Bodies b = random_grains(16000, 100);
  for (int i = 0; i < b.size(); i += 3) b.mass[i] = 8;  // The flow of heavy grains has a larger weight.
  // The flow is constant in each cell, with 300 times the thermal energy.
  const auto flow = [](Vec3 p) { return Vec3{10 * std::sin(std::floor(p.x / 5)), 3 * std::floor(p.y / 50), 0}; };
  set_in_motion(b, temperature, flow);
  const GranularTemperature found = granular_temperature(b, 5);
  // Chi squared with 3 (N - occupied cells) degrees of freedom; 8000 (1 - exp(-2)) of 8000 cells are occupied. The
  // bound is four standard deviations.
  const double freedom = 3 * (16000 - 8000 * (1 - std::exp(-2.0)));
  CHECK(std::abs(found.local / temperature - 1) < 4 * std::sqrt(2 / freedom));
  double all = 0;
  for (int i = 0; i < b.size(); ++i) all += b.mass[i] * norm2(velocity<3>(b, i)) / (3 * 16000);
  CHECK(found.total == Approx(all).epsilon(1e-12).scale(0));
}

TEST_CASE("granular temperature: NaN if each grain is alone in its averaging cell") {
  Bodies b = grains_at(20, {{1, 1, 1}, {11, 11, 11}});
  b.momentum = {3, 0, 0, 0, 0, 0};
  CHECK(std::isnan(granular_temperature(b).local));
  CHECK(granular_temperature(b).total == Approx(9.0 / 6));
}

TEST_CASE("contact clusters: found across periodic faces and corners of the box") {
  // 0-1 across a face, 1-2 and 2-4 adjacent, 3-5 across a corner, 6 isolated.
  Bodies b =
      grains_at(10, {{0.2, 5, 5}, {9.3, 5, 5}, {8.4, 5, 5}, {0.2, 0.2, 0.2}, {7.5, 5, 5}, {9.8, 9.8, 9.8}, {3, 3, 3}});
  b.charge = {1, 2, 4, 8, 16, 32, 64};
  b.mass[4] = 3;
  b.momentum[12] = 12;
  const std::vector<std::int32_t> numbers = cluster_numbers(b.size(), pairs_closer_than(b, 0));
  CHECK(numbers == std::vector{0, 0, 0, 3, 0, 3, 6});
  const std::vector<Cluster> found = clusters(b, numbers);
  REQUIRE(found.size() == 3);
  CHECK(found[0].grains == 4);
  CHECK(found[0].mass == 6);
  CHECK(found[0].charge == 23);
  CHECK(found[0].velocity.x == 2);
  CHECK(found[1].charge == 40);
  CHECK(found[2].grains == 1);
  const ClusterSizes sizes = cluster_sizes(numbers);
  CHECK(sizes.number == 3);
  CHECK(sizes.largest == 4);
  CHECK(sizes.aggregate == 3);
  CHECK(sizes.mean == Approx(21.0 / 7));
  CHECK(std::isnan(cluster_sizes(std::vector<std::int32_t>{0, 1}).aggregate));
}

TEST_CASE("bound_pairs: near, attracting, kinetic energy below the Coulomb energy") {
  Bodies b = grains_at(10, {{0.02, 5, 5}, {8.97, 5, 5}});  // The distance is 1.05.
  b.charge = {2, -2};
  // m_eff v^2 / 2 = v^2 / 4, compared with 4 K / 1.05.
  b.momentum[0] = 2 * std::sqrt(4 * 0.5 / 1.05) - 1e-6;
  CHECK(bound_pairs(b, 0.5) == std::vector{Pair{0, 1}});
  b.momentum[0] += 2e-6;
  CHECK(bound_pairs(b, 0.5).empty());
  b.momentum[0] = 0;
  b.charge = {2, 2};
  CHECK(bound_pairs(b, 0.5).empty());
  b.charge = {2, -2};
  b.position[0] = 0.08;
  CHECK(bound_pairs(b, 0.5).empty());
}

TEST_CASE("density clusters: adjacent cells above a packing threshold are united") {
  std::vector<Vec3> positions;
  fill(positions, {0, 0, 0}, 4);
  fill(positions, {4, 0, 0}, 5);  // Adjacent to the first across a face of the box.
  fill(positions, {4, 4, 4}, 4);  // This cell has only a corner in common with the first.
  fill(positions, {2, 2, 2}, 3);  // Not dense.
  const DensityClusters found = density_clusters(grains_at(10, positions));
  CHECK(found.least == 4);
  CHECK(found.size == std::vector{2, 1});
  CHECK(found.mean_size() == Approx(5.0 / 3));
  CHECK(std::isnan(density_clusters(grains_at(10, {{1, 1, 1}})).mean_size()));
  // 19 cells of 2.038, in which 1/3 of the closest packing is 3.99 grains.
  const DensityClusters gas_clusters = density_clusters(grains_at(38.73, {{1, 1, 1}}));
  CHECK(gas_clusters.cells.count[0] == 19);
  CHECK(gas_clusters.least == 4);
  CHECK(density_clusters(grains_at(38.76, {{1, 1, 1}})).least == 5);
  // 1/6 of the closest packing is 1.9 grains, 1/2 is 5.7.
  CHECK(density_clusters(grains_at(10, positions), 2, 1.0 / 6).least == 2);
  CHECK(density_clusters(grains_at(10, positions), 2, 1.0 / 6).size == std::vector{2, 1, 1});
  CHECK(density_clusters(grains_at(10, positions), 2, 0.5).size.empty());
}

TEST_CASE("density clusters: a box of 10^18 cells gives the result of a small box") {
  std::vector<Vec3> positions;
  fill(positions, {0, 0, 0}, 4);
  fill(positions, {1, 0, 0}, 5);
  fill(positions, {3, 3, 3}, 4);
  fill(positions, {4, 4, 4}, 3);  // Not dense.
  const DensityClusters in_small = density_clusters(grains_at(16, positions));
  const DensityClusters in_large = density_clusters(grains_at(2e6, positions));
  CHECK(in_large.cells.edge.x == 2);
  CHECK(in_large.least == in_small.least);
  CHECK(in_small.size == std::vector{2, 1});
  CHECK(in_large.size == in_small.size);
  // 10^27 cells are impossible: the cells are longer, and grains in one cell do not fill it.
  const DensityClusters lost = density_clusters(grains_at(2e9, positions));
  CHECK(lost.cells.count[0] == 1 << 20);
  CHECK(lost.size.empty());
}

TEST_CASE("granular temperature: boxes of 20 and 2e6 diameters give equal values") {
  Bodies small = grains_at(20, {{1, 1, 1}, {3, 1, 1}, {6, 1, 1}}),
         large = grains_at(2e6, {{1, 1, 1}, {3, 1, 1}, {6, 1, 1}});
  for (Bodies* b : {&small, &large}) b->momentum = {3, 0, 0, -1, 0, 0, 7, 0, 0};
  // The first two are in one cell of 5 and their velocities differ by 4: 2 * 2^2 / 3.
  CHECK(granular_temperature(small).local == Approx(8.0 / 3));
  CHECK(granular_temperature(large).local == granular_temperature(small).local);
}

TEST_CASE("occupied_cells: table and sorting assign the same cells to bodies") {
  const Bodies b = random_grains(300, 20);
  const Cells cells = cells_of(b, 2);  // 1000 cells: by a table.
  const OccupiedCells by_table = occupied_cells(b, cells);
  Bodies few = b;
  few.position.resize(3 * 200), few.mass.resize(200), few.radius.resize(200);  // More than four cells per body: by sorting.
  const OccupiedCells by_sorting = occupied_cells(few, cells);
  CHECK(std::ranges::is_sorted(by_table.cell));
  for (int i = 0; i < few.size(); ++i)
    CHECK(by_sorting.cell[by_sorting.body_cell[i]] == by_table.cell[by_table.body_cell[i]]);
  for (const OccupiedCells* found : {&by_table, &by_sorting})
    for (int c = 0; c < found->size(); ++c) CHECK(found->find(found->cell[c]) == c);
}

TEST_CASE("charge moments and Sonine coefficient: known samples give known values") {
  constexpr int n = 100'000;
  const std::vector<double> gaussian = samples(n, [](Random& random) { return 7 + 2 * random.normal(); });
  // Four standard deviations of the kurtosis of Gaussian samples, sqrt(24 / n).
  CHECK(std::abs(charge_moments(gaussian).kurtosis - 3) < 4 * std::sqrt(24.0 / n));
  // <q^2> = 49 + 4, and the variance of q^2 is 4 49 4 + 2 16.
  CHECK(std::abs(charge_moments(gaussian).square - 53) < 4 * std::sqrt(816.0 / n));
  const ChargeMoments pair = charge_moments(std::vector{-3.0, 3.0, -3.0, 3.0});
  CHECK(pair.magnitude == 3);
  CHECK(pair.square == 9);
  CHECK(pair.kurtosis == 1);
  CHECK(std::isnan(charge_moments(std::vector(1000, 0.1)).kurtosis));

  Bodies b = random_grains(n, 10);
  set_in_motion(b, 0.7, [](Vec3) { return Vec3{5, 0, 0}; });
  // With X = v^2/<v^2> the coefficient varies as 0.6 X^2 - 2 X, with a variance of 8/15 per grain. The bound is four
  // standard deviations.
  CHECK(std::abs(sonine(b)) < 4 * std::sqrt(8.0 / 15 / n));
  Bodies cross = grains_at(10, std::vector<Vec3>(6));
  for (int i = 0; i < 6; ++i) cross.momentum[3 * i + i / 2] = i % 2 ? 1 : -1;
  CHECK(sonine(cross) == Approx(-0.4));  // All have the same speed.
  CHECK(std::isnan(sonine(grains_at(10, {{1, 1, 1}}))));
}

TEST_CASE("correlation coefficient and histogram: known samples give known values") {
  const std::vector<double> x = {1, 2, 3, 4}, y = {2, 1, 4, 3};
  CHECK(correlation(x, std::vector{-3.0, -5.0, -7.0, -9.0}) == Approx(-1));
  CHECK(correlation(x, y) == Approx(0.6));
  CHECK(std::isnan(correlation(x, std::vector(4, 2.0))));

  const Histogram found = histogram(std::vector{0.0, 0.1, 0.9, 1.0, -0.1}, 0, 1, 2);
  CHECK(found.density == std::vector{0.8, 0.4});  // 2 and 1 of 5, over a width of 1/2.
  CHECK(found.middle(1) == 0.75);

  // Scaled speeds of a Maxwellian gas: the bin at the maximum, x^2 = 2/3, within four standard deviations.
  constexpr int n = 50'000;
  Bodies b = random_grains(n, 10);
  set_in_motion(b, 0.02, [](Vec3) { return Vec3{0, 3, 0}; });
  const Histogram speeds = histogram(scaled_speeds(b), 0, 4, 80);
  const double middle = speeds.middle(16), x2 = middle * middle;
  const double expected = std::sqrt(54 / std::numbers::pi) * x2 * std::exp(-1.5 * x2);
  // The bin's mean differs from the value at its centre by width^2 / 24 times the second derivative, which at the
  // maximum is 6 times the value.
  const double deviation = std::sqrt(expected / (0.05 * n)), curvature = 6 * expected * 0.05 * 0.05 / 24;
  CHECK(std::abs(speeds.density[16] - expected) < 4 * deviation + curvature);
}

}  // namespace analysis_gas_test
