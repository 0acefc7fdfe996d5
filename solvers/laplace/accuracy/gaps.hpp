#pragma once

#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

/// Narrowest gap between bodies of different potential, which determines the error of a grid.
struct NarrowGap {
  double gap = 0;     ///< Gap (m), at most two radii: larger ones do not matter
  double radius = 0;  ///< Radius (m) of the smaller disk
};

/// Returns the narrowest gap of a problem with at least one disk; gaps between two bars do not count. Without disks,
/// gap and radius are the length of the box.
NarrowGap narrowest(const LaplaceProblem& problem);

/// Returns a measure of the cut-cell method's error: (h/R)^(1/2) (h/gap)^(3/2) with h the cell edge, and (h/R)^(1/2) if
/// the gap has less than a cell (docs/numerics/cut-cells.md).
double difficulty(const NarrowGap& narrow_gap, double cell);
/// Error of the method over the difficulty, within a factor of five either way.
constexpr double likely_error = 0.04;
/// Returns the cell edge (m) for a given difficulty.
double cell_for(const NarrowGap& narrow_gap, double difficulty);

}  // namespace lichtenberg::laplace
