#pragma once

#include "solvers/geometry/vec.hpp"

namespace lichtenberg::laplace {

/// Numbers of cells along the longer side of a box that the cut-cell method supports. The fractions 1/2, 7/16, 6/16,
/// ... 1/4 of them are supported as well. The shorter side has whole cells, and fine grids can be halved often enough
/// for fast multigrid.
class Grids {
 public:
  /// Finds the grids of a box. Throws InputError if no grid fits a box of these proportions.
  explicit Grids(Vec2 size);

  int at_least(int cells) const;
  /// Returns the finest grid with at most this many cells. Throws InputError if even the coarsest has more.
  int at_most(int cells) const;

 private:
  int step(int units) const;
  int unit_;  ///< Smallest number of cells along the longer side with a whole number along the shorter
};

}  // namespace lichtenberg::laplace
