#pragma once

#include "solvers/geometry/vec.hpp"

namespace lichtenberg::laplace {

/// Numbers of cells along the longer side of a box that the cut-cell method supports. Each of these numbers times 1/2,
/// 7/16, 6/16, 5/16 or 1/4 is also supported. On all these grids the shorter side has an integer number of cells. Fine
/// grids can be halved often enough for fast multigrid.
class Grids {
 public:
  /// Finds the grids of a box. Throws InputError if the ratio of its sides is no ratio of whole numbers up to 2048.
  explicit Grids(Vec2 size);

  /// Returns the coarsest grid with at least this many cells.
  int at_least(int cells) const;
  /// Returns the finest grid with at most this many cells. Throws InputError if even the coarsest has more.
  int at_most(int cells) const;

 private:
  int step(int units) const;
  int unit_;  ///< Smallest number of cells along the longer side with a whole number along the shorter
};

}  // namespace lichtenberg::laplace
