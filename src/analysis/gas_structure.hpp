#pragma once

#include <span>
#include <vector>

#include "src/model/bodies.hpp"

namespace lichtenberg::analysis {

/// Structure factors of a periodic gas, averaged over shells of wave vectors. Shell s = 1, 2, ... contains |n| in [s -
/// 1/2, s + 1/2), with the wave vector k = 2 pi n/L along each axis. Uncorrelated positions give 1 on average.
struct StructureFactors {
  std::vector<double> density;  ///< |sum exp(ikr)|^2 / N
  std::vector<double> charge;   ///< |sum q exp(ikr)|^2 / sum q^2; empty if no grain is charged
};
constexpr int structure_shells = 6;
/// Computes the structure factors of density and charge in the first `shells` shells of wave vectors. They are
/// NaN in a box that is not periodic along all axes.
StructureFactors structure_factors(const Bodies& bodies, int shells = structure_shells);

/// Mach number of the flow: sqrt(<V_c^2>) / sqrt(T/m), averaged over occupied cells c of mean velocity V_c (G 5.60). T
/// is the granular temperature relative to the flow, m the mean mass.
struct MachNumber {
  double raw = 0;
  /// Value without the thermal contribution to <V_c^2>, which is d T / M_c for a cell of mass M_c in d dimensions; 0 if
  /// that is larger.
  double flow = 0;
};
/// Computes the Mach number of the flow in cells of about this edge (d0). Both values are NaN if no cell has two grains
/// or T = 0.
MachNumber mach_number(const Bodies& bodies, double edge);

/// Computes the mean square displacement (d0^2) of the same grains between two instants, unwrapped in periodic boxes.
double mean_square_displacement(const Bodies& before, const Bodies& now);

/// Computes the persistence of pairs: the fraction of the pairs `before` that are also in `now`; NaN if `before` is
/// empty. `now` must be in ascending order.
double persistence(std::span<const Pair> before, std::span<const Pair> now);

/// Averages the squared charge q^2/<q^2> over grains of similar speed |v|/<v^2>^(1/2), with q and v relative to their
/// means. Scaled speeds have `bins` bins of equal width from 0 to `fastest`; faster grains are left out. NaN in bins
/// without a grain.
std::vector<double> charge_by_speed(const Bodies& bodies, double fastest, int bins);

}  // namespace lichtenberg::analysis
