#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "solvers/fftw.hpp"
#include "solvers/parallel/team.hpp"

namespace lichtenberg::periodic {

/// Numbers on a periodic mesh, and their convolution with a function that is given by its Fourier transform. A row
/// along z goes on behind its end, by `halo` points, so that who spreads or takes need not wrap there.
class Convolution {
 public:
  /// The halo is 2 or more.
  Convolution(std::array<int, 3> points, int halo);

  std::array<int, 3> points() const { return points_; }
  /// Point (x, y, z) is at x * plane() + y * row() + z, with z below points()[2] + halo.
  double* data() { return mesh_.get(); }
  const double* data() const { return mesh_.get(); }
  std::ptrdiff_t row() const { return row_; }
  std::ptrdiff_t plane() const { return row_ * points_[1]; }

  /// Sets everything to 0.
  void clear(parallel::Team& team);
  /// Adds what is in the halo to the points that it stands for, multiplies mode (x, y, z) by
  /// factor[(y * points[0] + x) * (points[2] / 2 + 1) + z], and fills the halo. Transforms are not normalized.
  void apply(std::span<const double> factor, parallel::Team& team);

 private:
  fftw_complex* modes(int x, int y) {
    return reinterpret_cast<fftw_complex*>(modes_.get()) + (static_cast<std::ptrdiff_t>(y) * points_[0] + x) * column_;
  }
  void fold(int x);
  void unfold(int x);
  void filter(int y, std::span<const double> factor);

  std::array<int, 3> points_;
  int halo_;
  std::ptrdiff_t row_, column_;  ///< numbers in a row of the mesh, modes in one of the transform
  FftwNumbers mesh_;             ///< [x][y][row_]
  FftwNumbers modes_;  ///< complex, [y][x][column_]: the sheet of one y is together, for the transform along x
  FftwPlan forward_, backward_;              ///< of one plane, from the mesh to the modes and back
  FftwPlan sheet_forward_, sheet_backward_;  ///< of one sheet, in place
};

}  // namespace lichtenberg::periodic
