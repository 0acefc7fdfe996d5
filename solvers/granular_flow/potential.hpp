#pragma once

#include <array>
#include <span>
#include <vector>

#include "solvers/fftw.hpp"
#include "solvers/granular_flow/flow.hpp"

namespace lichtenberg::granular_flow {

/// The field -grad psi of lap psi = -(c - mean c) in a periodic square or cube, exactly for the trigonometric
/// polynomial through the cells' centres: no force of the charges on themselves as a whole, to rounding.
class Potential {
 public:
  explicit Potential(const Grid& grid);

  /// [dimension][cells], the field at the centres.
  const std::array<std::vector<double>, 3>& field(std::span<const double> charge);

 private:
  void differentiate(int axis);

  Grid grid_;
  std::size_t modes_;
  std::array<std::vector<double>, 3> wave_number_;  ///< of each mode; 0 at half the cells, where there is no slope
  FftwNumbers values_, charge_modes_, field_modes_;
  FftwPlan forward_, backward_;
  std::array<std::vector<double>, 3> field_;
};

}  // namespace lichtenberg::granular_flow
