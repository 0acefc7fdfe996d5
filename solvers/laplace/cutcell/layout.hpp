#pragma once

#include <cstddef>

#include "solvers/geometry/host_device.hpp"

namespace lichtenberg::laplace {

/// Memory layout of a grid of nx x ny cells in red-black (checkerboard) order: all cells of one colour, then those of
/// the other. A sweep over one colour thus accesses contiguous rows. Cell (i, j) has colour (i + j) mod 2 (0: red, 1:
/// black) and number i / 2 in its colour's row j. Padding of one row and some entries surrounds the grid. Vectors are
/// zero there, so that stencils need no boundary cases. The index of a cell in memory is called its slot.
struct Layout {
  int nx = 0, ny = 0;
  /// Number of slots (memory entries) of a row of one colour, padding included.
  std::ptrdiff_t stride = 0;

  /// Number of padding slots before each row: one AVX register of floats.
  static constexpr int pad = 8;

  Layout() = default;
  Layout(int nx_, int ny_) : nx(nx_), ny(ny_), stride(pad + ((nx_ + 1) / 2 + pad) / pad * pad) {}

  /// Returns the number of slots of the grid, padding included.
  LICHTENBERG_HOST_DEVICE std::ptrdiff_t size() const { return 2 * colour_size(); }
  /// Returns the number of slots of one colour, padding included.
  LICHTENBERG_HOST_DEVICE std::ptrdiff_t colour_size() const { return (ny + 2) * stride + pad; }
  /// Returns the slot (memory index) of the first cell of `colour` in row j. Rows -1 and ny are padding.
  LICHTENBERG_HOST_DEVICE std::ptrdiff_t row(int colour, int j) const {
    return colour * colour_size() + (j + 1) * stride + pad;
  }
  /// Returns the slot (memory index) of cell (i, j).
  LICHTENBERG_HOST_DEVICE std::ptrdiff_t operator()(int i, int j) const { return row((i + j) & 1, j) + (i >> 1); }
  /// Returns 0 or 1: the parity of the column i for cells of `colour` in row j.
  LICHTENBERG_HOST_DEVICE static int parity(int colour, int j) { return (colour + j) & 1; }
  /// Returns the number of cells of `colour` in row j.
  LICHTENBERG_HOST_DEVICE int row_length(int colour, int j) const { return (nx - parity(colour, j) + 1) / 2; }
};

struct CellIndex {
  int i, j;
};

/// Computes column i and row j of the cell at the memory index `slot`, the inverse of Layout::operator().
LICHTENBERG_HOST_DEVICE inline CellIndex cell_of(const Layout& at, int slot) {
  const int colour_size = static_cast<int>(at.colour_size()), stride = static_cast<int>(at.stride);
  const int colour = slot >= colour_size;
  const int inner = slot - colour * colour_size;
  const int j = inner / stride - 1;
  return {2 * (inner - (j + 1) * stride - Layout::pad) + Layout::parity(colour, j), j};
}

/// Returns true if cell (i, j) lies within the grid.
LICHTENBERG_HOST_DEVICE inline bool inside(const Layout& at, int i, int j) {
  return i >= 0 && i < at.nx && j >= 0 && j < at.ny;
}
/// Returns the number of cell faces on a side of the box: ny on the left and right (0, 1), nx at the bottom and top (2,
/// 3).
LICHTENBERG_HOST_DEVICE inline int faces_of(const Layout& at, int side) { return side < 2 ? at.ny : at.nx; }
/// Returns the cell that touches a side of the box at face number `face`, counted from the left or from the bottom.
/// `side`: 0 left, 1 right, 2 bottom, 3 top (SideIndex).
LICHTENBERG_HOST_DEVICE inline CellIndex cell_at_face(const Layout& at, int side, int face) {
  const int far = side == 1 ? at.nx - 1 : side == 3 ? at.ny - 1 : 0;
  return side < 2 ? CellIndex{far, face} : CellIndex{face, far};
}
/// Returns the change of the column i towards the neighbour on a side: -1, 0 or 1. `side`: 0 left, 1 right, 2 bottom, 3
/// top (SideIndex).
LICHTENBERG_HOST_DEVICE inline int step_i(int side) { return (side == 1) - (side == 0); }
/// Returns the change of the row j towards the neighbour on a side: -1, 0 or 1. `side`: 0 left, 1 right, 2 bottom, 3
/// top (SideIndex).
LICHTENBERG_HOST_DEVICE inline int step_j(int side) { return (side == 3) - (side == 2); }

}  // namespace lichtenberg::laplace
