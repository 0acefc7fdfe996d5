#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "src/analysis/gas_cells.hpp"
#include "src/model/bodies.hpp"

namespace lichtenberg::analysis {

/// Grains that pairs join, directly or by others, are one cluster, and a grain without any is one by itself (G 5.3).
/// [N]: of each grain the number of the first grain of its cluster.
std::vector<std::int32_t> cluster_numbers(int grains, std::span<const Pair> pairs);

/// In space, whatever the dimension.
Vec3 place_of(const Bodies& bodies, int i);

struct Cluster {
  int grains = 0;
  double mass = 0, charge = 0;
  Vec3 velocity{};  ///< mean by mass
};

/// The clusters that have these numbers, [N], in ascending order of their first grains.
std::vector<Cluster> clusters(const Bodies& bodies, std::span<const std::int32_t> numbers);

/// Each cluster as one body of its own, at the mean place of its grains, which are taken where they are nearest to its
/// first one: a cluster longer than half the box is somewhere within it. Of the volume of its grains.
Bodies cluster_bodies(const Bodies& bodies, std::span<const std::int32_t> numbers);

/// How large clusters are, in grains.
struct ClusterSizes {
  int number = 0;  ///< of clusters, lone grains among them
  int largest = 0;
  /// Number mean of aggregates, the clusters of two and more; NaN without any.
  double aggregate = std::numeric_limits<double>::quiet_NaN();
  double mean = 0;  ///< by mass, sum m^2 / sum m
};
ClusterSizes cluster_sizes(std::span<const std::int32_t> numbers);

/// The pairs whose surfaces are closer than a tenth of a diameter and whose energy is negative: m_eff v^2 / 2 +
/// strength q_i q_j / r < 0, of their relative motion and their own charges alone. A bound pair that bounces is not
/// always in contact. `strength`: K. None without charges.
std::vector<Pair> bound_pairs(const Bodies& bodies, double strength);

/// Where grains are dense (G 4.4.1): cells filled by more than a part of the closest packing, and those of them that
/// share faces, across the box too, as clusters.
struct DensityClusters {
  Cells cells;
  int least = 0;          ///< grains of the mean size that a cell must have
  std::vector<int> size;  ///< in cells, of each cluster
  /// S = sum s^2 N_s / sum s N_s (G 4.8), in cells; NaN without any.
  double mean_size() const;
};

constexpr double density_edge = 2;      ///< d0, of those cells, about; G does not say
constexpr double dense_part = 1.0 / 3;  ///< of the closest packing

/// That part of pi/sqrt(18) in space, of pi/sqrt(12) in the plane. A cell has the grains whose centres are in it.
double dense_filling(int dimension, double part = dense_part);
DensityClusters density_clusters(const Bodies& bodies, double edge = density_edge, double part = dense_part);

}  // namespace lichtenberg::analysis
