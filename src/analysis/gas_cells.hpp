#pragma once

#include <array>
#include <span>

#include "src/model/bodies.hpp"

namespace lichtenberg::analysis {

/// Equal cells that fill a box, counted along x first. A plane box has one layer of them.
struct Cells {
  std::array<int, 3> count{1, 1, 1};  ///< along each axis
  Vec3 edge{};                        ///< of a cell, d0; z is 0 in the plane
  int dimension = 3;

  int size() const { return count[0] * count[1] * count[2]; }
  /// Area or volume of one.
  double volume() const { return edge.x * edge.y * (dimension == 3 ? edge.z : 1); }
  /// The cell of a place, given by its `dimension` coordinates: 0 <= place < length of the box.
  int of(std::span<const double> place) const;
  /// The next one along an axis, around the box.
  int next(int cell, int axis) const;
};

/// A whole number of cells along each axis, whose edges are as near to `edge` (d0) as that allows; longer in a box that
/// would have more than a million of them and more than 64 a body, nearly all of them empty.
Cells cells_of(const Bodies& bodies, double edge);

/// [N] the cell of each body.
std::vector<int> cell_of_each(const Bodies& bodies, const Cells& cells);

}  // namespace lichtenberg::analysis
