#pragma once

// What a coarse grid of the preconditioner makes of conductors that it does not resolve. One source for the CPU
// (homogenize.cpp) and a CUDA device.
//
// A grid that keeps a conductor far smaller than its cells as a conductor does CG more harm than good (50 iterations in
// place of 13). What such a conductor does to the field on the scale of the cells is known: a dispersion of floating
// disks that fill a share f of the area is a medium of permittivity (1 + f) / (1 - f) (Maxwell Garnett 1904, in two
// dimensions), their charge is the medium's. One whose potential is given, or is shared with others far away, is a thin
// conductor: it exchanges flux with the four cells around it, as many as the logarithm of its radius lets through (what
// Peaceman 1978 does for the wells of a reservoir).

#include <cmath>
#include <numbers>

#include "solvers/laplace/cutcell/layout.hpp"
#include "solvers/laplace/cutcell/surface_links.hpp"

namespace lichtenberg::laplace {

/// Cells. Disks of a smaller radius are smeared out: those that float alone, and those that belong to a group or have a
/// given potential. Found by trial, over 5 to 50 % of the area, 324 to 15000 disks; half or twice as much costs a few
/// iterations.
inline constexpr double least_lone_radius = 0.7, least_radius = 0.5;

/// Cells. A group all of whose members are smeared out and lie within this has no potential of its own.
inline constexpr double least_extent = 1.5;

LICHTENBERG_HOST_DEVICE inline bool is_resolved(const Outline& body, bool floats_alone) {
  return body.kind != Outline::Kind::disk || body.size >= (floats_alone ? least_lone_radius : least_radius);
}

/// Permittivity of a cell of which the disks fill a share. It diverges where they fill everything.
LICHTENBERG_HOST_DEVICE inline float effective_permittivity(float fill) {
  constexpr float largest_fill = 0.8f;
  if (fill > largest_fill) fill = largest_fill;
  return (1 + fill) / (1 - fill);
}

/// Of the face between two cells: the two halves in series.
LICHTENBERG_HOST_DEVICE inline float face_conductance(float permittivity_a, float permittivity_b) {
  return 2 * permittivity_a * permittivity_b / (permittivity_a + permittivity_b);
}

/// Of a circle around a point of a box, the share that lies in it: half of one centred on a side. Where it meets two
/// sides the product of their shares, exact in a corner.
LICHTENBERG_HOST_DEVICE inline double share_in_box(Vec2 centre, double radius, const Layout& box) {
  const double distance[4] = {centre.x, box.nx - centre.x, centre.y, box.ny - centre.y};
  double share = 1;
  for (const double d : distance)
    if (d < radius) share *= 1 - std::acos(at_least(d / radius, -1.0)) / std::numbers::pi;
  return share;
}

/// Flux into a thin conductor, a disk much smaller than a cell, per difference to the potential of the cells around it,
/// weighed as in bilinear interpolation. A source in one cell has that cell's potential at a distance of
/// exp(-gamma) / sqrt 8 = 0.198 cells (Peaceman's equivalent radius; gamma is Euler's constant), one that is shared by
/// the four cells their weighed mean at 0.198 exp(2 pi s), s = sum of w_k w_l (G(0) - G(k - l)), where the square
/// lattice's G(0) - G is 1/4 beside and 1/pi across: 0.5 cells, with the mean of s over places between the cells. For a
/// disk that is not much smaller the logarithm is kept from zero. Only what lies in the box takes flux.
LICHTENBERG_HOST_DEVICE inline double thin_conductance(const Outline& disk, const Layout& box) {
  return 2 * std::numbers::pi / std::log(at_least(0.5 / disk.size, 1.5)) * share_in_box(disk.centre, disk.size, box);
}

/// The four cells around a point and their weights in bilinear interpolation; beyond the box lies its mirror image,
/// negative at an electrode.
struct Interpolation {
  std::ptrdiff_t cell[4];
  int row[4];
  float weight[4];
};

/// Lower left one of the four, from -1 on.
struct InterpolationBase {
  int i, j;
};
LICHTENBERG_HOST_DEVICE inline InterpolationBase interpolation_base(Vec2 p) {
  return {static_cast<int>(std::floor(p.x - 0.5)), static_cast<int>(std::floor(p.y - 0.5))};
}

/// The cell of a box of nx x ny cells of which another one, perhaps beyond it, is the image: itself within. The
/// potential changes sign at an electrode.
struct MirroredCell {
  int i, j;
  float sign = 1;

  /// `electrode`: by SideIndex.
  LICHTENBERG_HOST_DEVICE static MirroredCell of(int nx, int ny, int i, int j, const bool* electrode) {
    MirroredCell cell{i < 0 ? 0 : i < nx ? i : nx - 1, j < 0 ? 0 : j < ny ? j : ny - 1};
    if (i < 0 ? electrode[0] : i >= nx && electrode[1]) cell.sign = -cell.sign;
    if (j < 0 ? electrode[2] : j >= ny && electrode[3]) cell.sign = -cell.sign;
    return cell;
  }
};

/// By SideIndex, whether a side of the box is one.
inline std::array<bool, 4> electrodes(const LaplaceProblem& problem) {
  std::array<bool, 4> result;
  for (int side = 0; side < 4; ++side) result[side] = problem.sides[side].kind == Side::Kind::electrode;
  return result;
}

/// `electrode`: by SideIndex.
LICHTENBERG_HOST_DEVICE inline Interpolation interpolate(const Layout& at, Vec2 p, const bool* electrode) {
  const double x = p.x - 0.5, y = p.y - 0.5;
  const InterpolationBase base = interpolation_base(p);
  Interpolation result;
  for (int k = 0; k < 4; ++k) {
    const MirroredCell cell = MirroredCell::of(at.nx, at.ny, base.i + k % 2, base.j + k / 2, electrode);
    const double weight = (k % 2 ? x - base.i : 1 - x + base.i) * (k / 2 ? y - base.j : 1 - y + base.j);
    result.cell[k] = at(cell.i, cell.j);
    result.row[k] = cell.j;
    result.weight[k] = cell.sign * static_cast<float>(weight);
  }
  return result;
}

}  // namespace lichtenberg::laplace
