#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "src/model/bodies.hpp"

namespace lichtenberg::analysis {

/// Division of a box into equal cells, numbered along x first. A plane box has one layer of cells.
struct Cells {
  std::array<int, 3> count{1, 1, 1};  ///< along each axis
  Vec3 edge{};                        ///< edges of a cell, d0; z is 0 in two dimensions
  Vec3 corner{};                      ///< lower corner of the box, d0
  std::array<bool, 3> periodic{true, true, true};
  int dimension = 3;

  std::int64_t size() const { return std::int64_t{1} * count[0] * count[1] * count[2]; }
  /// Returns the area (d0^2) or volume (d0^3) of a cell.
  double volume() const { return edge.x * edge.y * (dimension == 3 ? edge.z : 1); }
  /// Returns the number of the cell that contains a position, given by its `dimension` coordinates. A position outside
  /// the box counts to the nearest cell.
  std::int64_t index(std::span<const double> position) const;
  /// Returns the number of the next cell along an axis; beyond the last one, the first if the axis is periodic, else
  /// -1.
  std::int64_t next(std::int64_t cell, int axis) const;
};

/// Divides the bodies' box into cells of about `edge` (d0). Their number along an axis is the box length over `edge`,
/// rounded, at least 1. Cells are larger in a box that would have more than 2^20 of them along an axis. Along axes that
/// are not periodic the box is enlarged so that it contains all bodies.
Cells cells_of(const Bodies& bodies, double edge);

/// List of the cells that contain bodies. It has at most one cell for each body, however large the box is.
struct OccupiedCells {
  std::vector<std::int64_t> cell;  ///< [M] numbers of these cells, ascending
  /// Index in `cell` of each body's cell, [N]: 0 ... M - 1
  std::vector<int> body_cell;

  int size() const { return static_cast<int>(cell.size()); }
  /// Returns the index in the list `cell` of the cell with the number `wanted`; -1 if this cell contains no body.
  int find(std::int64_t wanted) const;
};

/// Finds the cells that contain bodies, and the cell of each body.
OccupiedCells occupied_cells(const Bodies& bodies, const Cells& cells);

}  // namespace lichtenberg::analysis
