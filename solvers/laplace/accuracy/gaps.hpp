#pragma once

#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

/// Gap of a disk to a body or electrode of different potential that causes the largest error on a grid.
struct NarrowGap {
  double gap = 0;     ///< Surface distance (m), from 0 to two radii: wider gaps do not matter
  double radius = 0;  ///< Radius (m) of the disk, or of the smaller of two disks
};

/// Finds the gap that determines the cut-cell method's error: the gap with the smallest radius * gap^3. The radius is
/// that of the smaller disk; for a closed curve it is twice its area over its perimeter. Gaps between bars and rings do
/// not count, nor do those to sides with a varying potential. A disk without a gap below two radii counts with this
/// gap. Without any disk and closed curve, gap and radius are the longer side of the box.
NarrowGap narrowest(const LaplaceProblem& problem);

/// Computes an empirical measure of the cut-cell method's error, the difficulty. It is (h/R)^(1/2) (h/gap)^(3/2) with
/// the cell edge h (`cell`, m) and the radius R, or (h/R)^(1/2) if the gap is narrower than a cell
/// (docs/numerics/cut-cells.md).
double difficulty(const NarrowGap& narrow_gap, double cell);
/// Assumed relative error of the cut-cell method divided by the difficulty (empirical).
constexpr double likely_error = 0.04;
/// Computes the cell edge (m) at which a gap has the given difficulty: the inverse of difficulty().
double cell_for(const NarrowGap& narrow_gap, double difficulty);

}  // namespace lichtenberg::laplace
