#pragma once

#include <span>
#include <vector>

#include "src/model/bodies.hpp"

namespace lichtenberg::analysis {

/// Structure factors of a periodic gas by shells of wave vectors: shell s has those with |n| in [s - 1/2, s + 1/2), k =
/// 2 pi n/L along each axis, s = 1, 2, ... Places without any order have 1 in all.
struct StructureFactors {
  std::vector<double> density;  ///< |sum exp(ikr)|^2 / N
  std::vector<double> charge;   ///< |sum q exp(ikr)|^2 / sum q^2; empty if no grain is charged
};
constexpr int structure_shells = 6;
StructureFactors structure_factors(const Bodies& bodies, int shells = structure_shells);

/// How fast the flow is: sqrt(<V_c^2>) / sqrt(T/m) over the cells that are not empty (G 5.60), T relative to the flow.
struct MachNumber {
  double raw = 0;
  /// Without what T alone gives a cell of n_c grains, d T/(m n_c): 0 of a gas at rest, if less is left than nothing.
  double flow = 0;
};
/// m: mean mass. NaN where there is no temperature.
MachNumber mach_number(const Bodies& bodies, double edge);

/// Mean over the grains of how far each has come since `before`, squared, around the box or not.
double mean_square_displacement(const Bodies& before, const Bodies& now);

/// Of the pairs that there were the part that there still is; NaN if there was none. Both sorted.
double persistence(std::span<const Pair> before, std::span<const Pair> now);

/// Mean of q^2/<q^2> by |v|/<v^2>^(1/2), both about their means, in bins of equal width from 0 to `fastest`; NaN in
/// bins without a grain.
std::vector<double> charge_by_speed(const Bodies& bodies, double fastest, int bins);

}  // namespace lichtenberg::analysis
