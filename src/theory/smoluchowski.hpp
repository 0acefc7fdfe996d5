#pragma once

#include <functional>
#include <span>
#include <vector>

namespace lichtenberg::theory {

// Coagulation: aggregates of i and of j grains form one of i + j at the rate K_ij f_i f_j (Smoluchowski 1916; G 2.50,
// 4.12):
//
//   df_i/dt = 1/2 sum_j K_(i-j),j f_(i-j) f_j - f_i sum_j K_ij f_j,
//
// with f_1 = 1 at the start, in units in which K has no other factor.

/// Coagulation kernel K_ij of aggregates of i and of j grains.
using Kernel = std::function<double(double i, double j)>;

/// Returns the coagulation kernel (i^(1/3) + j^(1/3))^2 (1/i + 1/j)^(1/beta) of spheres with speeds i^(-1/beta) (G
/// 4.13), homogeneous of degree 2/3 - 1/beta. The dissertation G uses beta = 2 for neutral grains (equipartition) and 3
/// for charged ones.
Kernel flight_kernel(double beta);

/// Computes the growth exponent z of the mean size, S ~ t^z, for flight_kernel(beta): 1/(1/3 + 1/beta), which is 6/5
/// for beta = 2 and 3/2 for beta = 3.
double flight_exponent(double beta);

/// Computes the time at which aggregates would have this mean size if all had the same size s: ds/dt = K_ss/2 with
/// flight_kernel(beta). It maps another theory of the coalescence rate to coagulation time.
double flight_time(double beta, double size);

/// Makes the size classes of a discretized distribution: 1, 2, ..., `single`, then a geometric sequence with `ratio` up
/// to `largest`. Neighbouring sizes differ by at least 1, so that the last can exceed `largest` by less than 1.
std::vector<double> size_classes(int single, double ratio, double largest);

/// Size distribution of aggregates at one time, by size class.
struct SizeDistribution {
  double time = 0;
  std::vector<double> number;  ///< number of aggregates of each size, per initial grain
  double lost = 0;             ///< fraction of the mass in sizes beyond the largest

  /// Returns the moment sum_k size_k^power number_k of the distribution.
  double moment(std::span<const double> sizes, double power) const;
  /// Returns the mean size S = sum s^2 f_s / sum s f_s (G 4.8), in grains.
  double mean_size(std::span<const double> sizes) const;
};

/// Solves Smoluchowski's coagulation equation in these size classes, from single grains. Returns the distribution at
/// these times (ascending, >= 0), to 1e-7 except for the error of missing sizes. An aggregate of intermediate size is
/// divided between two classes such that number and mass are conserved (fixed pivots, Kumar and Ramkrishna 1996). S is
/// then too large by about (ratio - 1)^2. If more than `most_lost` of the mass is lost beyond the largest size, the
/// integration ends and fewer distributions are returned. `stiff`: for kernels that differ by many orders of magnitude;
/// the distribution is then accurate to 1e-5.
std::vector<SizeDistribution> coagulate(const Kernel& kernel, std::span<const double> sizes,
                                        std::span<const double> times, double most_lost = 1e-9, bool stiff = false);

/// Mean size and number of aggregates over time, extrapolated to infinitely narrow size classes.
struct CoagulationSeries {
  std::vector<double> size;    ///< S (G 4.8) at each time, up to the time at which mass is lost
  std::vector<double> number;  ///< number of aggregates, per initial grain
  double lost = 0;             ///< fraction of the mass in sizes beyond the largest
  double error = 0;            ///< estimated relative error of S due to the class widths
  double ratio = 0;            ///< ratio of neighbouring sizes in the finest classes used

  /// Returns the standard deviation of the sizes of aggregates over their mean, at each time: sqrt(S number - 1).
  std::vector<double> relative_width() const;
};

/// Accuracy and limits of coagulation_series().
struct CoagulationOptions {
  double tolerance = 1e-4;  ///< relative error of S by the class widths
  double largest = 1e6;     ///< largest size of an aggregate
  bool stiff = false;       ///< as in coagulate()
};

/// Computes mean size S and number of aggregates at these times (ascending, >= 0) from Smoluchowski's equation, in size
/// classes up to `options.largest` grains. The error of geometric classes is quadratic in their width, so values of two
/// widths are extrapolated to zero width (Richardson). Widths are halved until two extrapolations of S differ by at
/// most three times the tolerance, or the ratio is 1.0075.
CoagulationSeries coagulation_series(const Kernel& kernel, std::span<const double> times,
                                     const CoagulationOptions& options = {});

}  // namespace lichtenberg::theory
