#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "src/analysis/gas_cells.hpp"
#include "src/model/bodies.hpp"

namespace lichtenberg::analysis {

/// Finds the clusters of grains: the connected components of `pairs`, such as contacts (G 5.3). Returns for each grain
/// the index of the first grain of its cluster, [N]. A grain without pairs is a cluster of its own.
std::vector<std::int32_t> cluster_numbers(int grains, std::span<const Pair> pairs);

/// Returns the position of grain i (d0) as a vector in space; z is 0 in two dimensions.
Vec3 grain_position(const Bodies& bodies, int i);

/// A cluster of grains: number of grains, mass, charge and velocity, in reduced units.
struct Cluster {
  int grains = 0;
  double mass = 0, charge = 0;
  Vec3 velocity{};  ///< mass-weighted mean
};

/// Computes the size, mass, charge and velocity of each cluster, in ascending order of first grains. `numbers`: result
/// of cluster_numbers(), [N].
std::vector<Cluster> clusters(const Bodies& bodies, std::span<const std::int32_t> numbers);

/// Makes one body of each cluster, with the mass, charge, momentum and volume (area) of its grains, in ascending order
/// of first grains. A body's position is the mean of the grains' positions, each as the periodic image nearest to the
/// cluster's first grain. The position is wrong for a cluster that extends farther than half the box from that grain.
/// `numbers`: result of cluster_numbers(), [N].
Bodies cluster_bodies(const Bodies& bodies, std::span<const std::int32_t> numbers);

/// Statistics of cluster sizes, in grains.
struct ClusterSizes {
  int number = 0;  ///< number of clusters, including isolated grains
  int largest = 0;
  /// Mean size of aggregates, which are clusters of two or more grains; NaN without any.
  double aggregate = NAN;
  double mean = 0;  ///< mass-weighted mean, sum m^2 / sum m
};
/// Computes the statistics of cluster sizes. `numbers`: result of cluster_numbers(), [N].
ClusterSizes cluster_sizes(std::span<const std::int32_t> numbers);

/// Finds the electrostatically bound pairs of grains. Their surface gap is below a tenth of the sum of their radii. The
/// energy of their relative motion and of their two charges is negative: m_eff v^2 / 2 + strength q_i q_j / r < 0.
/// `strength`: Coulomb's constant in reduced units. A bound pair that bounces is not always in contact. Empty without
/// charges.
std::vector<Pair> bound_pairs(const Bodies& bodies, double strength);

/// Clusters of dense cells (G 4.4.1). A cell is dense if its filling fraction exceeds a given part of that of the
/// closest packing. Dense cells that share a face, also across periodic sides, form a cluster.
struct DensityClusters {
  Cells cells;
  int least = 0;          ///< smallest number of grains of the mean size in a dense cell
  std::vector<int> size;  ///< size of each cluster, in cells
  /// Returns the mean cluster size S = sum s^2 N_s / sum s N_s (G 4.8), in cells, with N_s clusters of s cells. NaN
  /// without any cluster.
  double mean_size() const;
};

/// Approximate edge (d0) of the cells for density clusters; the source (G) does not specify it
constexpr double density_edge = 2;
constexpr double dense_part = 1.0 / 3;  ///< fraction of the closest packing

/// Returns the filling fraction above which a cell is dense: `part` times that of the closest packing, pi/sqrt(18) in
/// three dimensions or pi/sqrt(12) in two. A cell contains the grains whose centres are in it.
double dense_filling(int dimension, double part = dense_part);
/// Finds the clusters of dense cells. `edge`: d0, approximate edge of the cells. `part`: fraction of the closest
/// packing above which a cell is dense.
DensityClusters density_clusters(const Bodies& bodies, double edge = density_edge, double part = dense_part);

}  // namespace lichtenberg::analysis
