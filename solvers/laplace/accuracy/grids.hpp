#pragma once

#include "solvers/geometry/vec.hpp"

namespace lichtenberg::laplace {

/// Grids of a box for error estimates with the cut-cell method: the permitted numbers of square cells along the longer
/// side. If n cells are permitted, a grid with n times 1/2, 7/16, 6/16, 5/16 or 1/4 cells is also possible. On all
/// these grids the shorter side has a whole number of cells. Fine grids can be halved often enough for fast multigrid.
class Grids {
 public:
  /// Finds the grids of a box of the given size (m). Throws InputError if the ratio of its sides is no ratio of whole
  /// numbers up to 2048.
  explicit Grids(Vec2 size);

  /// Returns the number of cells along the longer side of the coarsest grid with at least `cells` there.
  int at_least(int cells) const;
  /// Returns the number of cells along the longer side of the finest grid with at most `cells` there. Throws InputError
  /// if even the coarsest grid has more.
  int at_most(int cells) const;

 private:
  int step(int units) const;
  int unit_;  ///< Smallest number of cells along the longer side with a whole number along the shorter
};

}  // namespace lichtenberg::laplace
