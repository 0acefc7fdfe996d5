#pragma once

#include <array>
#include <span>
#include <vector>

#include "solvers/fftw.hpp"
#include "solvers/granular_flow/flow.hpp"

namespace lichtenberg::granular_flow {

/// Spectral Poisson solver by FFT in a periodic square or cube. It computes the field -grad psi with lap psi = -(c -
/// mean c). The charge density c is the trigonometric polynomial through the values at the cells' centres. The total
/// force of the charges on themselves is 0 to rounding.
class Potential {
 public:
  explicit Potential(const Grid& grid);

  /// Returns the field at the cells' centres, [axis][cell], of the charge density `charge` (c, one value per cell). The
  /// reference is valid until the next call.
  const std::array<std::vector<double>, 3>& field(std::span<const double> charge);

 private:
  void differentiate(int axis);

  Grid grid_;
  std::size_t modes_;
  /// Wave number of each mode along each axis, for derivatives: 0 for the highest mode of an even number of cells,
  /// whose slope is 0 at all centres.
  std::array<std::vector<double>, 3> wave_number_;
  /// Square of the wave vector of each mode.
  std::vector<double> square_;
  FftwNumbers values_, charge_modes_, field_modes_;
  FftwPlan forward_, backward_;
  std::array<std::vector<double>, 3> field_;
};

}  // namespace lichtenberg::granular_flow
