#pragma once

#include <cstdint>

#include "solvers/geometry/vec.hpp"

namespace lichtenberg::laplace {

/// What is at a cell's centre: a body, or fluid. On a device the fluid cells that have a link are numbered (boundary
/// cells), and their number stands here. All in one integer: -1 is fluid, so that memory filled with ones is, and a
/// cell that several bodies want goes to the first one by an atomic minimum of the indices (device/grid.hpp).
class Cover {
 public:
  Cover() = default;  ///< fluid
  LICHTENBERG_HOST_DEVICE static constexpr Cover by(int body) { return Cover(body); }
  LICHTENBERG_HOST_DEVICE static constexpr Cover boundary_cell(int number) { return Cover(-2 - number); }

  LICHTENBERG_HOST_DEVICE constexpr bool is_fluid() const { return code_ < 0; }
  LICHTENBERG_HOST_DEVICE constexpr bool is_boundary_cell() const { return code_ <= -2; }
  LICHTENBERG_HOST_DEVICE constexpr bool is(int body) const { return code_ == body; }
  /// Index of the body; of a covered cell only.
  LICHTENBERG_HOST_DEVICE constexpr int body() const { return code_; }
  /// Of a boundary cell only.
  LICHTENBERG_HOST_DEVICE constexpr int boundary_number() const { return -2 - code_; }

 private:
  LICHTENBERG_HOST_DEVICE constexpr explicit Cover(std::int32_t code) : code_(code) {}
  std::int32_t code_ = -1;
};

}  // namespace lichtenberg::laplace
