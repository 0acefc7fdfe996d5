#pragma once

#include <cstdint>

#include "solvers/geometry/vec.hpp"

namespace lichtenberg::laplace {

/// Owner of a grid cell: the body (conductor) that covers the cell, or the fluid between the bodies. One integer stores
/// it: the index of a body, or -1 for fluid. The device solver also numbers its boundary cells, the fluid cells next to
/// a conductor: -2 - k means boundary cell k. Memory filled with one bits means fluid. An atomic minimum over unsigned
/// integers gives a cell to the first of several bodies (device/grid.hpp).
class CellOwner {
 public:
  /// Makes the owner of a fluid cell that has no number because it is not a boundary cell.
  CellOwner() = default;
  /// Returns the owner of a cell that the body with index `body` covers.
  LICHTENBERG_HOST_DEVICE static constexpr CellOwner by(int body) { return CellOwner(body); }
  /// Returns the owner of a boundary cell: a fluid cell next to a conductor, with its index `number`.
  LICHTENBERG_HOST_DEVICE static constexpr CellOwner boundary_cell(int number) { return CellOwner(-2 - number); }

  /// Returns true for a fluid cell, numbered or not.
  LICHTENBERG_HOST_DEVICE constexpr bool is_fluid() const { return code_ < 0; }
  LICHTENBERG_HOST_DEVICE constexpr bool is_boundary_cell() const { return code_ <= -2; }
  LICHTENBERG_HOST_DEVICE constexpr bool is(int body) const { return code_ == body; }
  /// Returns the index of the body that covers the cell. The cell must not be fluid.
  LICHTENBERG_HOST_DEVICE constexpr int body() const { return code_; }
  /// Returns the index of a boundary cell (a fluid cell next to a conductor). The cell must be a boundary cell.
  LICHTENBERG_HOST_DEVICE constexpr int boundary_number() const { return -2 - code_; }

 private:
  LICHTENBERG_HOST_DEVICE constexpr explicit CellOwner(std::int32_t code) : code_(code) {}
  std::int32_t code_ = -1;
};

}  // namespace lichtenberg::laplace
