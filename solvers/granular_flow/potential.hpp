#pragma once

#include <array>
#include <span>
#include <vector>

#include "solvers/fftw.hpp"
#include "solvers/granular_flow/flow.hpp"

namespace lichtenberg::granular_flow {

/// Field -grad psi of lap psi = -(c - mean c) in a periodic square or cube, exact for the trigonometric polynomial
/// through the cells' centres. The total force of the charges on themselves is 0 to rounding.
class Potential {
 public:
  explicit Potential(const Grid& grid);

  /// Returns the field at the centres, [dimension][cells].
  const std::array<std::vector<double>, 3>& field(std::span<const double> charge);

 private:
  void differentiate(int axis);

  Grid grid_;
  std::size_t modes_;
  std::array<std::vector<double>, 3> wave_number_;  ///< Wave number of each mode; 0 for the highest mode of an even
                                                    ///< number of cells, which has no slope
  FftwNumbers values_, charge_modes_, field_modes_;
  FftwPlan forward_, backward_;
  std::array<std::vector<double>, 3> field_;
};

}  // namespace lichtenberg::granular_flow
