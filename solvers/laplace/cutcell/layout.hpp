#pragma once

#include <cstddef>

#include "solvers/geometry/host_device.hpp"

namespace lichtenberg::laplace {

/// Memory layout of a grid's cells: split by colour (checkerboard), so that a sweep over one colour accesses contiguous
/// rows. Cell (i, j) has colour (i + j) mod 2 and number i / 2 in its colour's row j. One row and some slots of padding
/// surround the grid. They are always zero, so that stencils need no boundary cases.
struct Layout {
  int nx = 0, ny = 0;
  /// Slots in a row of one colour.
  std::ptrdiff_t stride = 0;

  /// Padding before each row: an AVX register of floats.
  static constexpr int pad = 8;

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

struct CellIndex {
  int i, j;
};

/// Returns the cell of a slot.
LICHTENBERG_HOST_DEVICE inline CellIndex cell_of(const Layout& at, int slot) {
  const int colour_size = static_cast<int>(at.colour_size()), stride = static_cast<int>(at.stride);
  const int colour = slot >= colour_size;
  const int inner = slot - colour * colour_size;
  const int j = inner / stride - 1;
  return {2 * (inner - (j + 1) * stride - Layout::pad) + Layout::parity(colour, j), j};
}

LICHTENBERG_HOST_DEVICE inline bool inside(const Layout& at, int i, int j) {
  return i >= 0 && i < at.nx && j >= 0 && j < at.ny;
}
/// Return the number of faces on a side of the box, and the cell at one of them.
LICHTENBERG_HOST_DEVICE inline int faces_of(const Layout& at, int side) { return side < 2 ? at.ny : at.nx; }
LICHTENBERG_HOST_DEVICE inline CellIndex cell_at_face(const Layout& at, int side, int face) {
  const int far = side == 1 ? at.nx - 1 : side == 3 ? at.ny - 1 : 0;
  return side < 2 ? CellIndex{far, face} : CellIndex{face, far};
}
LICHTENBERG_HOST_DEVICE inline int step_i(int side) { return (side == 1) - (side == 0); }
LICHTENBERG_HOST_DEVICE inline int step_j(int side) { return (side == 3) - (side == 2); }

}  // namespace lichtenberg::laplace
