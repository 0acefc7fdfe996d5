#pragma once

#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "src/model/bodies.hpp"

namespace lichtenberg::analysis {

/// A cluster in space, put together along its own pairs across the sides of a periodic box.
struct ClusterShape {
  int grains = 0;
  double gyration = 0;       ///< R_g: rms distance of the grains' centres from their mean
  double charge_dipole = 0;  ///< |sum (q_i - <q>) (r_i - mean)|, which is 0 without charges
  bool percolates = false;   ///< its pairs lead around the box: it has no extent then, R_g and charge_dipole are NaN
  /// |sum mu_i| of the grains' induced dipoles (G 7.1), which needs no extent; 0 without any.
  double induced_dipole = 0;
};

/// Of all clusters of at least so many grains, in ascending order of their first grains. `dipole`: [3 N] of the grains,
/// or empty.
std::vector<ClusterShape> cluster_shapes(const Bodies& bodies, std::span<const Pair> pairs, int least = 2,
                                         std::span<const double> dipole = {});

/// A quantity of clusters against their mass: its mean by how many grains they have, from 0 on; NaN where there is no
/// cluster or its value is NaN.
std::vector<double> mean_by_grains(std::span<const ClusterShape> shapes, double ClusterShape::*quantity);

/// D_f of m ~ R_g^D_f: 1/D_f is the slope of log R_g over log m, since R_g has the scatter; the other way round is
/// biased low by 10 to 40 % while the range is short.
struct ClusterDimension {
  double dimension = 0;
  double error = 0;         ///< standard error, by the scatter about the line
  double from = 0, to = 0;  ///< range of R_g
  int clusters = 0;
};

constexpr int least_grains = 6;  ///< of clusters that count: a dimer has R_g = 1/2 whatever its shape

/// `as_balls`: with R_g^2 + 3 d^2/20, what grains that are balls of diameter 1 have. Empty if fewer than five clusters
/// of so many grains do not percolate, or if all of them are equally large.
std::optional<ClusterDimension> cluster_dimension(std::span<const ClusterShape> shapes, int least = least_grains,
                                                  bool as_balls = false);

/// Exponent tau of sizes that are distributed as s^-tau from `least` on, by maximum likelihood (Clauset, Shalizi and
/// Newman 2009, discrete); G quotes slopes, -tau.
struct SizeExponent {
  double exponent = 0;
  double error = 0;  ///< standard error
  int clusters = 0;  ///< of that size and larger
};
/// Empty if fewer than ten clusters are that large, or all of them of size `least`. least >= 1.
std::optional<SizeExponent> size_exponent(std::span<const int> sizes, int least = 1);

}  // namespace lichtenberg::analysis
