#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "src/model/bodies.hpp"

namespace lichtenberg::analysis {

/// Equal cells that fill a box, counted along x first. A plane box has one layer of them.
struct Cells {
  std::array<int, 3> count{1, 1, 1};  ///< along each axis
  Vec3 edge{};                        ///< of a cell, d0; z is 0 in the plane
  int dimension = 3;

  std::int64_t size() const { return std::int64_t{1} * count[0] * count[1] * count[2]; }
  /// Area or volume of one.
  double volume() const { return edge.x * edge.y * (dimension == 3 ? edge.z : 1); }
  /// The cell of a place, given by its `dimension` coordinates: 0 <= place < length of the box.
  std::int64_t of(std::span<const double> place) const;
  /// The next one along an axis, around the box.
  std::int64_t next(std::int64_t cell, int axis) const;
};

/// A whole number of cells along each axis, whose edges are as near to `edge` (d0) as that allows; longer in a box that
/// would have more than 2^20 of them along an axis.
Cells cells_of(const Bodies& bodies, double edge);

/// The cells that hold bodies. Memory and time to find them grow with the bodies, not with the box.
struct OccupiedCells {
  std::vector<std::int64_t> cell;  ///< [M] ascending
  std::vector<int> of_body;        ///< [N] 0 ... M - 1: which of them holds the body

  int size() const { return static_cast<int>(cell.size()); }
  /// Returns the index of a cell in `cell`; -1 for an empty cell.
  int find(std::int64_t wanted) const;
};

OccupiedCells occupied_cells(const Bodies& bodies, const Cells& cells);

}  // namespace lichtenberg::analysis
