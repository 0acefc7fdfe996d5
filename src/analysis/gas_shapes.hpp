#pragma once

#include <optional>
#include <span>
#include <vector>

#include "src/model/bodies.hpp"

namespace lichtenberg::analysis {

/// Shape of a cluster, unwrapped along its pairs across periodic sides.
struct ClusterShape {
  int grains = 0;
  double gyration = 0;       ///< radius of gyration R_g: rms distance of the grains' centres from their mean
  double charge_dipole = 0;  ///< |sum (q_i - <q>) (r_i - mean)|; 0 without charges
  /// True if its pairs connect around the box. It then has no extent, and R_g and charge_dipole are NaN.
  bool percolates = false;
  /// |sum mu_i| of the grains' induced dipoles (G 7.1), which needs no extent; 0 without dipoles.
  double induced_dipole = 0;
};

/// Returns the shapes of all clusters of at least `least` grains, in ascending order of their first grains. `dipole`:
/// [3 N] of the grains, or empty.
std::vector<ClusterShape> cluster_shapes(const Bodies& bodies, std::span<const Pair> pairs, int least = 2,
                                         std::span<const double> dipole = {});

/// Returns the mean of a quantity of clusters by number of grains, from 0 on; NaN where there is no cluster or its
/// value is NaN.
std::vector<double> mean_by_grains(std::span<const ClusterShape> shapes, double ClusterShape::*quantity);

/// Fractal dimension D_f of m ~ R_g^D_f. 1/D_f is the slope of log R_g over log m, because R_g has the scatter. The
/// inverse regression is biased low by 10 to 40 % for a short range.
struct ClusterDimension {
  double dimension = 0;
  double error = 0;         ///< standard error from the scatter about the line
  double from = 0, to = 0;  ///< range of R_g
  int clusters = 0;
};

/// Smallest clusters that count: a dimer has R_g = 1/2 whatever its shape
constexpr int least_grains = 6;

/// Fits the dimension. `as_balls`: uses R_g^2 + 3 d^2/20, the value for grains that are balls of diameter 1. Empty if
/// fewer than five clusters of at least `least` grains are finite, or if all of them have the same size.
std::optional<ClusterDimension> cluster_dimension(std::span<const ClusterShape> shapes, int least = least_grains,
                                                  bool as_balls = false);

/// Exponent tau of sizes with the distribution s^-tau from `least` on, by maximum likelihood (Clauset, Shalizi and
/// Newman 2009, discrete). G quotes slopes, -tau.
struct SizeExponent {
  double exponent = 0;
  double error = 0;  ///< standard error
  int clusters = 0;  ///< number of clusters of size `least` or larger
};
/// Fits the exponent. Empty if fewer than ten clusters have at least size `least`, or if all of them have size `least`.
/// least >= 1.
std::optional<SizeExponent> size_exponent(std::span<const int> sizes, int least = 1);

}  // namespace lichtenberg::analysis
