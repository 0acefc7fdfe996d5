#pragma once

#include <cstddef>

#include "solvers/geometry/host_device.hpp"

namespace lichtenberg::laplace {

/// Where the cells of a grid lie in memory: split by colour (checkerboard), so that a sweep over one colour reads and
/// writes contiguous rows. Cell (i, j) has colour (i + j) mod 2 and is number i / 2 in its colour's row j. A row and a
/// few slots of padding lie around the grid; they hold zero always, so that stencils need no boundary cases.
struct Layout {
  int nx = 0, ny = 0;
  std::ptrdiff_t stride = 0;  ///< slots a row of one colour

  static constexpr int pad = 8;  // a whole AVX register of floats in front of each row

  Layout() = default;
  Layout(int nx_, int ny_) : nx(nx_), ny(ny_), stride(pad + ((nx_ + 1) / 2 + pad) / pad * pad) {}

  LICHTENBERG_HOST_DEVICE std::ptrdiff_t size() const { return 2 * colour_size(); }
  LICHTENBERG_HOST_DEVICE std::ptrdiff_t colour_size() const { return (ny + 2) * stride + pad; }
  /// Slot of the first cell of `colour` in row j (j = -1 and ny are padding).
  LICHTENBERG_HOST_DEVICE std::ptrdiff_t row(int colour, int j) const {
    return colour * colour_size() + (j + 1) * stride + pad;
  }
  LICHTENBERG_HOST_DEVICE std::ptrdiff_t operator()(int i, int j) const { return row((i + j) & 1, j) + (i >> 1); }
  /// Parity of i for cells of `colour` in row j.
  LICHTENBERG_HOST_DEVICE static int parity(int colour, int j) { return (colour + j) & 1; }
  /// Number of cells of `colour` in row j.
  LICHTENBERG_HOST_DEVICE int row_length(int colour, int j) const { return (nx - parity(colour, j) + 1) / 2; }
};

}  // namespace lichtenberg::laplace
