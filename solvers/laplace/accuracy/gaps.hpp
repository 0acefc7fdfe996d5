#pragma once

#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

/// Where a grid has the hardest work: between bodies of different potential, the closer the harder.
struct NarrowPlace {
  double gap = 0;     ///< m, no more than two radii: what is farther does not matter
  double radius = 0;  ///< m, of the smaller disk
};

/// Of a problem with a disk at least; two bars do not make a narrow place. Without disks gap and radius are the box's.
NarrowPlace narrowest(const LaplaceProblem& problem);

/// The cut-cell method's error goes like (h/R)^(1/2) (h/gap)^(3/2), h being the cell, and like (h/R)^(1/2) where the
/// gap holds less than a cell (README.md).
double difficulty(const NarrowPlace& place, double cell);
/// The method's error over the difficulty, to a factor of five either way.
constexpr double likely_error = 0.04;
/// The cell of a given difficulty.
double cell_for(const NarrowPlace& place, double difficulty);

}  // namespace lichtenberg::laplace
