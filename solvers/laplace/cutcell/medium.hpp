#pragma once

// Conductors that a coarse grid of the preconditioner does not resolve. One source for the CPU (homogenize.hpp) and
// CUDA devices.
//
// Conductors far smaller than a grid's cells, if kept as conductors, slow CG down (50 iterations instead of 13). Their
// effect on the field at the scale of the cells is known. A dispersion of floating disks that fill a fraction f of the
// area is a medium of permittivity (1 + f) / (1 - f) (Maxwell Garnett 1904, in two dimensions), which carries their
// charge. A conductor with a given potential, or with the potential of distant ones, is a subgrid conductor. It
// exchanges flux with the four cells around it, like a well in reservoir simulation (Peaceman 1978). The conductance
// depends on the logarithm of its radius.

#include <cmath>
#include <numbers>

#include "solvers/laplace/cutcell/layout.hpp"
#include "solvers/laplace/cutcell/surface_links.hpp"

namespace lichtenberg::laplace {

/// Minimum radius (cells) of resolved disks: that float alone, and that belong to a group or have a given potential.
/// Determined empirically with 324 to 15000 disks that fill 5 to 50 % of the area; a factor of two costs a few
/// iterations.
inline constexpr double least_lone_radius = 0.7, least_radius = 0.5;

/// Maximum extent (cells) of an absorbed group, none of whose members is resolved.
inline constexpr double least_extent = 1.5;

/// Minimum length (cells) of a resolved bar. A bar of this length covers a cell centre at any angle (covers()). Without
/// one it would have no link.
inline constexpr double least_bar_length = std::numbers::sqrt2;

/// Returns true if a coarse grid resolves the body. `floats_alone`: its group has no other body and no given potential.
LICHTENBERG_HOST_DEVICE inline bool is_resolved(const Outline& body, bool floats_alone) {
  if (body.kind == Outline::Kind::ring) return true;
  if (body.kind == Outline::Kind::bar) return norm(body.end - body.centre) >= least_bar_length;
  return body.size >= (floats_alone ? least_lone_radius : least_radius);
}

/// Returns the disk by which a coarse grid represents an unresolved disk or bar. The radius for a bar is the mean of
/// its two half sides, as for the capacitance of an ellipse with these half axes.
LICHTENBERG_HOST_DEVICE inline Outline unresolved_disk(const Outline& body) {
  if (body.kind != Outline::Kind::bar) return body;
  return {Outline::Kind::disk, 0.5 * (body.centre + body.end), {}, 0.25 * (norm(body.end - body.centre) + body.size)};
}

/// Returns the relative permittivity of a cell of which disks fill the fraction `fill`. The formula diverges at 1.
LICHTENBERG_HOST_DEVICE inline float effective_permittivity(float fill) {
  constexpr float largest_fill = 0.8f;
  if (fill > largest_fill) fill = largest_fill;
  return (1 + fill) / (1 - fill);
}

/// Returns the conductance of the face between two cells: the two halves in series.
LICHTENBERG_HOST_DEVICE inline float face_conductance(float permittivity_a, float permittivity_b) {
  return 2 * permittivity_a * permittivity_b / (permittivity_a + permittivity_b);
}

/// Returns the fraction of a circle that lies in the box, 1/2 for a centre on a side. For a circle that meets two sides
/// it is the product of their fractions, exact for a centre in a corner.
LICHTENBERG_HOST_DEVICE inline double share_in_box(Vec2 centre, double radius, const Layout& box) {
  const double distance[4] = {centre.x, box.nx - centre.x, centre.y, box.ny - centre.y};
  double share = 1;
  for (const double d : distance)
    if (d < radius) share *= 1 - std::acos(at_least(d / radius, -1.0)) / std::numbers::pi;
  return share;
}

/// Returns the conductance between a subgrid conductor, a disk much smaller than a cell, and the bilinear mean of the
/// four cells around it. A source in one cell has the cell's potential at a distance of exp(-gamma) / sqrt 8 = 0.198
/// cells (Peaceman's equivalent radius; gamma: Euler's constant). For a source divided among four cells, the distance
/// for their weighted mean is 0.198 exp(2 pi s), with s = sum of w_k w_l (G(0) - G(k - l)). The square lattice's G(0) -
/// G is 1/4 for neighbours and 1/pi across a diagonal. With the mean of s over positions between the cells this is 0.5
/// cells. A lower bound keeps the logarithm from zero for larger disks. Only the part in the box takes flux.
LICHTENBERG_HOST_DEVICE inline double subgrid_conductance(const Outline& disk, const Layout& box) {
  return 2 * std::numbers::pi / std::log(at_least(0.5 / disk.size, 1.5)) * share_in_box(disk.centre, disk.size, box);
}

/// The four cells around a point and their weights in bilinear interpolation. Cells beyond the box are mirror images,
/// with negative weights at an electrode.
struct Interpolation {
  std::ptrdiff_t cell[4];
  int row[4];
  float weight[4];
};

/// Lower left cell of the four; indices start at -1.
struct InterpolationBase {
  int i, j;
};
LICHTENBERG_HOST_DEVICE inline InterpolationBase interpolation_base(Vec2 p) {
  return {static_cast<int>(std::floor(p.x - 0.5)), static_cast<int>(std::floor(p.y - 0.5))};
}

/// Cell of a box of which a given cell is the mirror image; a cell within the box is its own. The potential of the
/// image changes sign at an electrode.
struct MirroredCell {
  int i, j;
  float sign = 1;

  /// Returns the cell that mirrors (i, j) at the sides of the box. Each electrode among these sides changes its sign.
  /// `electrode`: by SideIndex.
  LICHTENBERG_HOST_DEVICE static MirroredCell of(int nx, int ny, int i, int j, const bool* electrode) {
    MirroredCell cell{i < 0 ? 0 : i < nx ? i : nx - 1, j < 0 ? 0 : j < ny ? j : ny - 1};
    if (i < 0 ? electrode[0] : i >= nx && electrode[1]) cell.sign = -cell.sign;
    if (j < 0 ? electrode[2] : j >= ny && electrode[3]) cell.sign = -cell.sign;
    return cell;
  }
};

/// Returns by SideIndex whether a side of the box is an electrode.
inline std::array<bool, 4> electrodes(const LaplaceProblem& problem) {
  std::array<bool, 4> result;
  for (int side = 0; side < 4; ++side) result[side] = problem.sides[side].kind == Side::Kind::electrode;
  return result;
}

/// Returns the four cells around a point and their weights in a bilinear interpolation. Cells beyond a side are
/// mirrored, with opposite sign at an electrode. `electrode`: by SideIndex.
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
