#include "solvers/granular_flow/potential.hpp"

#include <algorithm>
#include <numbers>

namespace lichtenberg::granular_flow {
namespace {

/// Returns the wave number of mode n.
double wave_number(int n, const Grid& grid) {
  return 2 * std::numbers::pi / grid.length * (2 * n <= grid.cells ? n : n - grid.cells);
}

fftw_complex* complex(const FftwNumbers& numbers) { return reinterpret_cast<fftw_complex*>(numbers.get()); }

}  // namespace

Potential::Potential(const Grid& grid) : grid_(grid) {
  const int deep = grid.cells / 2 + 1;
  modes_ = grid.size() / grid.cells * deep;
  square_.assign(modes_, 0);
  for (int axis = 0; axis < grid.dimension; ++axis) {
    field_[axis].resize(grid.size());
    std::size_t below = 1;  // Number of consecutive modes with the same index along this axis
    for (int k = axis + 1; k < grid.dimension; ++k) below *= k + 1 == grid.dimension ? deep : grid.cells;
    const int count = axis + 1 == grid.dimension ? deep : grid.cells;
    for (std::size_t mode = 0; mode < modes_; ++mode) {
      const int n = static_cast<int>(mode / below % count);
      const double k = wave_number(n, grid);
      square_[mode] += k * k;
      wave_number_[axis].push_back(2 * n == grid.cells ? 0 : k);
    }
  }
  values_ = make_fftw_numbers(grid.size());
  charge_modes_ = make_fftw_numbers(2 * modes_);
  field_modes_ = make_fftw_numbers(2 * modes_);
  const std::array cells{grid.cells, grid.cells, grid.cells};
  // Estimated plans: measured ones, and with them the rounding, would vary from run to run.
  forward_.reset(fftw_plan_dft_r2c(grid.dimension, cells.data(), values_.get(), complex(charge_modes_), fftw_planning));
  backward_.reset(fftw_plan_dft_c2r(grid.dimension, cells.data(), complex(field_modes_), values_.get(), fftw_planning));
}

/// Computes the modes of the field, -i k c_k / k^2.
void Potential::differentiate(int axis) {
  for (std::size_t mode = 0; mode < modes_; ++mode) {
    const double k = wave_number_[axis][mode];
    const double factor = k != 0 ? k / (square_[mode] * static_cast<double>(grid_.size())) : 0;
    const double* from = complex(charge_modes_)[mode];
    double* to = complex(field_modes_)[mode];
    to[0] = factor * from[1], to[1] = -factor * from[0];
  }
}

const std::array<std::vector<double>, 3>& Potential::field(std::span<const double> charge) {
  std::ranges::copy(charge, values_.get());
  fftw_execute(forward_.get());
  for (int axis = 0; axis < grid_.dimension; ++axis) {
    differentiate(axis);
    fftw_execute(backward_.get());
    std::copy_n(values_.get(), grid_.size(), field_[axis].begin());
  }
  return field_;
}

}  // namespace lichtenberg::granular_flow
