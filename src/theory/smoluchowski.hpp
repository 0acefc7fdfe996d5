#pragma once

#include <functional>
#include <span>
#include <vector>

namespace lichtenberg::theory {

// Aggregates of i and of j grains become one of i + j at the rate K_ij f_i f_j (Smoluchowski 1916; G 2.50, 4.12):
//   df_i/dt = 1/2 sum_j K_(i-j),j f_(i-j) f_j - f_i sum_j K_ij f_j
// from f_1 = 1, in units in which K has no other factor.

using Kernel = std::function<double(double i, double j)>;

/// (i^(1/3) + j^(1/3))^2 (1/i + 1/j)^(1/beta), of spheres that fly at a speed of i^(-1/beta) (G 4.13): homogeneous of
/// degree 2/3 - 1/beta. beta = 2 has G for neutral grains (equipartition), 3 for charged ones.
Kernel flight_kernel(double beta);

/// z of S ~ t^z for that kernel, 1/(1/3 + 1/beta): 6/5 and 3/2.
double flight_exponent(double beta);

/// When aggregates would have this mean size, were they all of one size s: ds/dt = K_ss/2 for that kernel. It paces
/// coagulation where the rate of mergers has a theory of its own.
double flight_time(double beta, double size);

/// Which sizes there are: 1, 2, ..., `single`, then each `ratio` times the one before, up to `largest`.
std::vector<double> size_classes(int single, double ratio, double largest);

struct SizeDistribution {
  double time = 0;
  std::vector<double> number;  ///< of aggregates of each size, by initial grain
  double lost = 0;             ///< share of the mass that has grown beyond the largest size

  /// sum_k size_k^power number_k.
  double moment(std::span<const double> sizes, double power) const;
  /// S = sum s^2 f_s / sum s f_s (G 4.8).
  double mean_size(std::span<const double> sizes) const;
};

/// The distribution at these times (rising, >= 0), to 1e-7 but for what sizes that are missing cost: an aggregate of a
/// size between two is shared among them, such that number and mass are kept (fixed pivots, Kumar and Ramkrishna 1996;
/// S is too large, by (ratio - 1)^2 about). Ends early when more than `most_lost` of the mass is lost: fewer come back.
std::vector<SizeDistribution> coagulate(const Kernel& kernel, std::span<const double> sizes,
                                        std::span<const double> times, double most_lost = 1e-9);

/// Moments over time, without the classes that they were computed with.
struct CoagulationCourse {
  std::vector<double> size;    ///< S (G 4.8) at each time, up to where mass is lost
  std::vector<double> number;  ///< of aggregates, by initial grain
  double lost = 0;             ///< share of the mass that has grown beyond the largest size
  double error = 0;            ///< of S, relative, by an estimate: what the widths of classes cost
  double ratio = 0;            ///< of neighbouring sizes, in the finest classes that were used
};

/// S and the number of aggregates at these times (rising, >= 0), up to a million grains. The error of geometric classes
/// goes with the square of their width: values of two widths are extrapolated to none (Richardson), and widths are
/// halved until two extrapolations differ by less than three times `tolerance`, or the ratio is 1.0075.
CoagulationCourse coagulation_course(const Kernel& kernel, std::span<const double> times, double tolerance = 1e-4);

}  // namespace lichtenberg::theory
