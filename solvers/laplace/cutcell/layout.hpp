#pragma once

#include <cstddef>

#include "solvers/geometry/host_device.hpp"

namespace lichtenberg::laplace {

/// Range of rows of a grid: `begin` to `end` - 1.
struct Rows {
  int begin = 0, end = 0;

  LICHTENBERG_HOST_DEVICE int count() const { return end - begin; }
  LICHTENBERG_HOST_DEVICE bool contains(int j) const { return j >= begin && j < end; }
};

/// Memory layout of a grid of nx x ny cells in red-black (checkerboard) order: all cells of one colour, then those of
/// the other. A sweep over one colour thus accesses contiguous rows. Cell (i, j) has colour (i + j) mod 2 (0: red, 1:
/// black) and number i / 2 in its colour's row j. Padding of one row and some entries surrounds the grid. Vectors are
/// zero there, so that stencils need no boundary cases. The index of a cell in memory is called its slot.
/// A process may own some rows of the grid only (a slab). It stores them and a few rows of its neighbours, the ghost
/// rows. Row indices j are those of the whole grid.
struct Layout {
  int nx = 0, ny = 0;
  /// Number of slots (memory entries) of a row of one colour, padding included.
  std::ptrdiff_t stride = 0;
  /// Rows that this process owns: all of a grid that is not divided among processes.
  Rows own;
  /// Rows in memory: the process's own and its ghost rows.
  Rows stored;

  /// Number of padding slots before each row: one AVX register of floats.
  static constexpr int pad = 8;
  /// Number of ghost rows on either side of a slab. The discretization is incomplete in the outermost two, because
  /// links depend on the owners of cells up to two rows away. A pass of the V-cycle uses six (Grid::ghosts_before).
  static constexpr int ghosts = 10;

  Layout() = default;
  Layout(int nx_, int ny_) : Layout(nx_, ny_, Rows{0, ny_}) {}
  /// Makes the layout of a slab: the rows `own_` of a grid of nx x ny cells, with ghost rows.
  Layout(int nx_, int ny_, Rows own_)
      : nx(nx_), ny(ny_), stride(pad + ((nx_ + 1) / 2 + pad) / pad * pad), own(own_), stored(extended(ghosts)) {}

  /// Returns the own rows and up to `more` rows on either side of them, as far as the grid extends.
  LICHTENBERG_HOST_DEVICE Rows extended(int more) const {
    return {own.begin < more ? 0 : own.begin - more, own.end > ny - more ? ny : own.end + more};
  }
  /// Returns true if several processes own rows of the grid.
  LICHTENBERG_HOST_DEVICE bool is_divided() const { return own.count() < ny; }
  /// Returns true for a grid that is not divided, and in the process with the first rows of a divided one. In sums over
  /// processes, this process adds the terms that all have in common.
  LICHTENBERG_HOST_DEVICE bool is_first() const { return own.begin == 0; }
  /// Returns true if this process owns the cell at the memory index `slot`.
  LICHTENBERG_HOST_DEVICE bool owns(std::ptrdiff_t slot) const {
    const std::ptrdiff_t inner = slot < colour_size() ? slot : slot - colour_size();
    return inner >= row(0, own.begin) && inner < row(0, own.end);
  }

  /// Returns the number of slots of the stored rows, padding included.
  LICHTENBERG_HOST_DEVICE std::ptrdiff_t size() const { return 2 * colour_size(); }
  /// Returns the number of slots of one colour, padding included.
  LICHTENBERG_HOST_DEVICE std::ptrdiff_t colour_size() const { return (stored.count() + 2) * stride + pad; }
  /// Returns the slot (memory index) of the first cell of `colour` in row j. The rows before and after the stored ones
  /// are padding.
  LICHTENBERG_HOST_DEVICE std::ptrdiff_t row(int colour, int j) const {
    return colour * colour_size() + (j + 1 - stored.begin) * stride + pad;
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
  const int stored = inner / stride - 1, j = stored + at.stored.begin;
  return {2 * (inner - (stored + 1) * stride - Layout::pad) + Layout::parity(colour, j), j};
}

/// Returns true if cell (i, j) lies within the stored rows of the grid.
LICHTENBERG_HOST_DEVICE inline bool inside(const Layout& at, int i, int j) {
  return i >= 0 && i < at.nx && at.stored.contains(j);
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
