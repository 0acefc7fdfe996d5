#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "src/analysis/gas_cells.hpp"
#include "src/model/bodies.hpp"

namespace lichtenberg::analysis {

/// Returns for each grain the index of the first grain of its cluster, [N]. Clusters are the connected components of
/// `pairs`; a grain without pairs is a cluster of its own (G 5.3).
std::vector<std::int32_t> cluster_numbers(int grains, std::span<const Pair> pairs);

/// Returns the position of a grain as a vector in space, for any dimension.
Vec3 grain_position(const Bodies& bodies, int i);

struct Cluster {
  int grains = 0;
  double mass = 0, charge = 0;
  Vec3 velocity{};  ///< mass-weighted mean
};

/// Returns the clusters with these numbers, [N], in ascending order of their first grains.
std::vector<Cluster> clusters(const Bodies& bodies, std::span<const std::int32_t> numbers);

/// Returns each cluster as one body with the volume of its grains. Its position is the mean of its grains' positions,
/// each as the image nearest to the cluster's first grain. For a cluster longer than half the box the position is only
/// approximate.
Bodies cluster_bodies(const Bodies& bodies, std::span<const std::int32_t> numbers);

/// Cluster sizes in grains.
struct ClusterSizes {
  int number = 0;  ///< number of clusters, including isolated grains
  int largest = 0;
  /// Number mean of aggregates, which are clusters of two or more grains; NaN without any.
  double aggregate = NAN;
  double mean = 0;  ///< mass-weighted mean, sum m^2 / sum m
};
ClusterSizes cluster_sizes(std::span<const std::int32_t> numbers);

/// Returns the pairs with a surface gap below a tenth of a diameter and a negative energy of relative motion and own
/// charges: m_eff v^2 / 2 + strength q_i q_j / r < 0. A bound pair that bounces is not always in contact. `strength`:
/// K. Empty without charges.
std::vector<Pair> bound_pairs(const Bodies& bodies, double strength);

/// Clusters of dense cells (G 4.4.1). A cell is dense if its filling exceeds a fraction of that of the closest packing.
/// Dense cells that share a face, also across periodic sides, form a cluster.
struct DensityClusters {
  Cells cells;
  int least = 0;          ///< smallest number of grains of the mean size in a dense cell
  std::vector<int> size;  ///< size of each cluster, in cells
  /// Returns S = sum s^2 N_s / sum s N_s (G 4.8), in cells; NaN without any cluster.
  double mean_size() const;
};

/// d0, approximate edge of the cells; G does not specify it
constexpr double density_edge = 2;
constexpr double dense_part = 1.0 / 3;  ///< fraction of the closest packing

/// Returns the filling of a dense cell: `part` times pi/sqrt(18) in three dimensions or pi/sqrt(12) in two. A cell
/// contains the grains whose centres are in it.
double dense_filling(int dimension, double part = dense_part);
DensityClusters density_clusters(const Bodies& bodies, double edge = density_edge, double part = dense_part);

}  // namespace lichtenberg::analysis
