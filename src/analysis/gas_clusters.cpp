#include "src/analysis/gas_clusters.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "solvers/disjoint_sets.hpp"
#include "src/model/neighbours.hpp"

namespace lichtenberg::analysis {
namespace {

using std::numbers::pi;

std::vector<int> grains_by_number(std::span<const std::int32_t> numbers) {
  std::vector<int> grains(numbers.size());
  for (const std::int32_t number : numbers) ++grains[number];
  return grains;
}

/// Returns the energy of the relative motion and of the two charges.
double energy_of(const Bodies& b, Pair p, double strength, double distance) {
  double v2 = 0;
  for (int k = 0; k < b.dimension; ++k) {
    const double v = b.momentum[p.j * b.dimension + k] / b.mass[p.j] - b.momentum[p.i * b.dimension + k] / b.mass[p.i];
    v2 += v * v;
  }
  const double mass = b.mass[p.i] * b.mass[p.j] / (b.mass[p.i] + b.mass[p.j]);
  return 0.5 * mass * v2 + strength * b.charge[p.i] * b.charge[p.j] / distance;
}

/// Area or volume of a grain.
double volume(double radius, int dimension) {
  return dimension == 3 ? 4 * pi / 3 * radius * radius * radius : pi * radius * radius;
}

/// Marks the occupied cells whose filling exceeds a fraction of that of the closest packing.
std::vector<bool> dense_cells(const Bodies& b, const OccupiedCells& occupied, double cell_volume, double part) {
  std::vector<double> filled(occupied.size());
  for (int i = 0; i < b.size(); ++i) filled[occupied.body_cell[i]] += volume(b.radius[i], b.dimension);
  std::vector<bool> dense(occupied.size());
  for (int c = 0; c < occupied.size(); ++c) dense[c] = filled[c] > dense_filling(b.dimension, part) * cell_volume;
  return dense;
}

}  // namespace

std::vector<std::int32_t> cluster_numbers(int grains, std::span<const Pair> pairs) {
  DisjointSets sets(grains);
  for (const Pair pair : pairs) sets.unite(pair.i, pair.j);
  std::vector<std::int32_t> numbers(grains);
  for (int i = 0; i < grains; ++i) numbers[i] = sets.find(i);
  return numbers;
}

std::vector<Cluster> clusters(const Bodies& bodies, std::span<const std::int32_t> numbers) {
  std::vector<Cluster> by_number(bodies.size());
  for (int i = 0; i < bodies.size(); ++i) {
    Cluster& cluster = by_number[numbers[i]];
    ++cluster.grains;
    cluster.mass += bodies.mass[i];
    if (!bodies.charge.empty()) cluster.charge += bodies.charge[i];
    for (int k = 0; k < bodies.dimension; ++k) cluster.velocity[k] += bodies.momentum[i * bodies.dimension + k];
  }
  std::erase_if(by_number, [](const Cluster& cluster) { return cluster.grains == 0; });
  for (Cluster& cluster : by_number) cluster.velocity *= 1 / cluster.mass;
  return by_number;
}

Vec3 grain_position(const Bodies& bodies, int i) {
  return bodies.dimension == 2 ? in_space(position<2>(bodies, i)) : position<3>(bodies, i);
}

Bodies cluster_bodies(const Bodies& bodies, std::span<const std::int32_t> numbers) {
  const int d = bodies.dimension;
  std::vector<Vec3> offset_sum(bodies.size());  // sum of the vectors from each cluster's first grain to its grains
  std::vector<double> filled(bodies.size());
  for (int i = 0; i < bodies.size(); ++i) {
    offset_sum[numbers[i]] += bodies.box.difference(grain_position(bodies, i), grain_position(bodies, numbers[i]));
    filled[numbers[i]] += std::pow(bodies.radius[i], d);
  }
  Bodies found{.dimension = d, .box = bodies.box};
  const std::vector<Cluster> all = clusters(bodies, numbers);
  auto cluster = all.begin();
  for (int i = 0; i < bodies.size(); ++i) {
    if (numbers[i] != i) continue;
    for (int k = 0; k < d; ++k) {
      found.position.push_back(grain_position(bodies, i)[k] + offset_sum[i][k] / cluster->grains);
      found.momentum.push_back(cluster->mass * cluster->velocity[k]);
    }
    found.mass.push_back(cluster->mass);
    found.radius.push_back(std::pow(filled[i], 1.0 / d));
    if (!bodies.charge.empty()) found.charge.push_back(cluster->charge);
    ++cluster;
  }
  found.image.assign(found.position.size(), 0);
  wrap(found);
  return found;
}

ClusterSizes cluster_sizes(std::span<const std::int32_t> numbers) {
  ClusterSizes sizes;
  int aggregates = 0;
  double squares = 0, in_aggregates = 0;
  for (const int grains : grains_by_number(numbers)) {
    sizes.number += grains > 0;
    sizes.largest = std::max(sizes.largest, grains);
    squares += static_cast<double>(grains) * grains;
    if (grains < 2) continue;
    ++aggregates;
    in_aggregates += grains;
  }
  if (aggregates > 0) sizes.aggregate = in_aggregates / aggregates;
  if (!numbers.empty()) sizes.mean = squares / static_cast<double>(numbers.size());
  return sizes;
}

std::vector<Pair> bound_pairs(const Bodies& bodies, double strength) {
  constexpr double near = 1.1;  // distance over the sum of radii
  std::vector<Pair> bound;
  if (bodies.charge.empty() || bodies.size() == 0) return bound;
  const double largest = *std::ranges::max_element(bodies.radius);
  visit_spheres(bodies, [&](const auto& grains) {
    for (const Pair p : pairs_closer_than(grains, (near - 1) * 2 * largest)) {
      const double distance = norm(grains.box.difference(grains.centre(p.j), grains.centre(p.i)));
      if (distance < near * (bodies.radius[p.i] + bodies.radius[p.j]) && energy_of(bodies, p, strength, distance) < 0)
        bound.push_back(p);
    }
  });
  return bound;
}

double DensityClusters::mean_size() const {
  double first = 0, second = 0;
  for (const double s : size) first += s, second += s * s;
  return first > 0 ? second / first : NAN;
}

double dense_filling(int dimension, double part) {
  return (dimension == 3 ? pi / std::sqrt(18.0) : pi / std::sqrt(12.0)) * part;
}

DensityClusters density_clusters(const Bodies& bodies, double edge, double part) {
  DensityClusters found{.cells = cells_of(bodies, edge)};
  if (bodies.size() == 0) return found;
  const double all = std::transform_reduce(bodies.radius.begin(), bodies.radius.end(), 0.0, std::plus<>(),
                                           [&](double radius) { return volume(radius, bodies.dimension); });
  const double least = dense_filling(bodies.dimension, part) * found.cells.volume() / (all / bodies.size());
  found.least = 1 + static_cast<int>(std::min(least, 1e9));
  const OccupiedCells occupied = occupied_cells(bodies, found.cells);
  const std::vector<bool> dense = dense_cells(bodies, occupied, found.cells.volume(), part);
  std::vector<Pair> faces;
  for (int c = 0; c < occupied.size(); ++c)
    for (int axis = 0; dense[c] && axis < bodies.dimension; ++axis)
      if (const int next = occupied.find(found.cells.next(occupied.cell[c], axis)); next >= 0 && dense[next])
        faces.push_back({c, next});
  std::vector<int> size(occupied.size());
  const std::vector<std::int32_t> number = cluster_numbers(occupied.size(), faces);
  for (int c = 0; c < occupied.size(); ++c) size[number[c]] += dense[c];
  std::ranges::copy_if(size, std::back_inserter(found.size), [](int s) { return s > 0; });
  return found;
}

}  // namespace lichtenberg::analysis
