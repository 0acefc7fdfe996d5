#pragma once

#include <optional>
#include <span>
#include <vector>

#include "src/model/bodies.hpp"

namespace lichtenberg::analysis {

/// Shape of a cluster of grains, unwrapped along its pairs across periodic sides. Lengths in d0, charges in q0.
struct ClusterShape {
  int grains = 0;
  double gyration = 0;       ///< radius of gyration R_g: rms distance of the grains' centres from their mean
  double charge_dipole = 0;  ///< |sum (q_i - <q>) (r_i - mean)|; 0 without charges
  /// Percolation: true if pairs connect the cluster to its own periodic image. R_g and charge_dipole are then NaN.
  bool percolates = false;
  /// Magnitude |sum mu_i| of the sum of the grains' induced dipoles (G 7.1), defined also for percolating clusters; 0
  /// without dipoles.
  double induced_dipole = 0;
};

/// Computes the shapes of all clusters (connected components of `pairs`) of at least `least` grains, in ascending order
/// of their first grains. `dipole`: induced dipoles of the grains, [3 N], or empty.
std::vector<ClusterShape> cluster_shapes(const Bodies& bodies, std::span<const Pair> pairs, int least = 2,
                                         std::span<const double> dipole = {});

/// Averages a quantity over clusters of the same number of grains. Element n is the mean of the finite values of
/// clusters of n grains; NaN if there are none.
std::vector<double> mean_by_grains(std::span<const ClusterShape> shapes, double ClusterShape::*quantity);

/// Fractal dimension D_f of clusters, m ~ R_g^D_f, with m grains and radius of gyration R_g. 1/D_f is the slope of log
/// R_g over log m, because R_g has the scatter.
struct ClusterDimension {
  double dimension = 0;
  double error = 0;         ///< standard error from the scatter about the line
  double from = 0, to = 0;  ///< range of R_g
  int clusters = 0;
};

/// Smallest number of grains of clusters that count for the fractal dimension: a dimer always has R_g = 1/2.
constexpr int least_grains = 6;

/// Fits the fractal dimension of clusters of at least `least` grains. `as_balls`: adds 3/20 d0^2 to R_g^2, the value
/// for grains that are balls of diameter d0. Clusters that percolate (connect to their periodic image) are left out.
/// Empty if fewer than five clusters are left, if they all have the same size, or if R_g does not increase with size.
std::optional<ClusterDimension> cluster_dimension(std::span<const ClusterShape> shapes, int least = least_grains,
                                                  bool as_balls = false);

/// Exponent tau of cluster sizes s with the distribution s^-tau above a smallest size, by maximum likelihood (Clauset,
/// Shalizi and Newman 2009, discrete). The dissertation G quotes slopes, -tau.
struct SizeExponent {
  double exponent = 0;
  double error = 0;  ///< standard error
  int clusters = 0;  ///< number of clusters of the smallest size or larger
};
/// Fits the exponent tau of the size distribution s^-tau for sizes of at least `least` >= 1. Empty if fewer than ten
/// clusters have such sizes, if all of them have size `least`, or if tau is not between 1.01 and 9.99.
std::optional<SizeExponent> size_exponent(std::span<const int> sizes, int least = 1);

}  // namespace lichtenberg::analysis
