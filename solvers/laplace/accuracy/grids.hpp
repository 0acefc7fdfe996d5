#pragma once

#include "solvers/geometry/vec.hpp"

namespace lichtenberg::laplace {

/// The numbers of cells along the longer side of a box that the cut-cell method can take, and a half, 7/16, 6/16, ... a
/// quarter of them as well: the shorter side has whole cells, and fine grids can be halved often enough for fast
/// multigrid.
class Grids {
 public:
  /// Throws InputError if a box of these proportions has none.
  explicit Grids(Vec2 size);

  int at_least(int cells) const;
  /// The finest with no more cells than that. Throws InputError if even the coarsest has more.
  int at_most(int cells) const;

 private:
  int step(int units) const;
  int unit_;  ///< smallest number of cells along the longer side that gives whole ones along the shorter
};

}  // namespace lichtenberg::laplace
