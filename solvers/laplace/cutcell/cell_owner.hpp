#pragma once

#include <cstdint>

#include "solvers/geometry/vec.hpp"

namespace lichtenberg::laplace {

/// Owner of a cell: the body that covers the cell's centre, or the fluid. On a device, fluid cells with links are
/// numbered (boundary cells), and this class stores the number. The code is a single integer, -1 for fluid. Memory
/// filled with one bits is thus fluid, and an atomic minimum assigns a cell to the first body (device/grid.hpp).
class CellOwner {
 public:
  /// Fluid.
  CellOwner() = default;
  LICHTENBERG_HOST_DEVICE static constexpr CellOwner by(int body) { return CellOwner(body); }
  LICHTENBERG_HOST_DEVICE static constexpr CellOwner boundary_cell(int number) { return CellOwner(-2 - number); }

  LICHTENBERG_HOST_DEVICE constexpr bool is_fluid() const { return code_ < 0; }
  LICHTENBERG_HOST_DEVICE constexpr bool is_boundary_cell() const { return code_ <= -2; }
  LICHTENBERG_HOST_DEVICE constexpr bool is(int body) const { return code_ == body; }
  /// Returns the index of the body; requires a covered cell.
  LICHTENBERG_HOST_DEVICE constexpr int body() const { return code_; }
  /// Requires a boundary cell.
  LICHTENBERG_HOST_DEVICE constexpr int boundary_number() const { return -2 - code_; }

 private:
  LICHTENBERG_HOST_DEVICE constexpr explicit CellOwner(std::int32_t code) : code_(code) {}
  std::int32_t code_ = -1;
};

}  // namespace lichtenberg::laplace
