#pragma once

#include <span>
#include <vector>

#include "src/model/bodies.hpp"

namespace lichtenberg::analysis {

/// Structure factors of a periodic gas by shells of wave vectors. Shell s = 1, 2, ... contains |n| in [s - 1/2, s +
/// 1/2), k = 2 pi n/L along each axis. Uncorrelated positions have 1 in all shells.
struct StructureFactors {
  std::vector<double> density;  ///< |sum exp(ikr)|^2 / N
  std::vector<double> charge;   ///< |sum q exp(ikr)|^2 / sum q^2; empty if no grain is charged
};
constexpr int structure_shells = 6;
StructureFactors structure_factors(const Bodies& bodies, int shells = structure_shells);

/// Mach number of the flow: sqrt(<V_c^2>) / sqrt(T/m) over occupied cells (G 5.60), T relative to the flow.
struct MachNumber {
  double raw = 0;
  /// Value corrected for the thermal contribution d T/(m n_c) of a cell of n_c grains; 0 for a gas at rest and where
  /// the correction exceeds the value.
  double flow = 0;
};
/// Returns the Mach number; m is the mean mass. NaN without a temperature.
MachNumber mach_number(const Bodies& bodies, double edge);

/// Mean square displacement of the grains since `before`, unwrapped in periodic boxes.
double mean_square_displacement(const Bodies& before, const Bodies& now);

/// Returns the fraction of the pairs `before` that are also in `now`; NaN if `before` is empty. Both are sorted.
double persistence(std::span<const Pair> before, std::span<const Pair> now);

/// Returns the mean of q^2/<q^2> by |v|/<v^2>^(1/2), both about their means, in bins of equal width from 0 to
/// `fastest`. NaN in bins without a grain.
std::vector<double> charge_by_speed(const Bodies& bodies, double fastest, int bins);

}  // namespace lichtenberg::analysis
