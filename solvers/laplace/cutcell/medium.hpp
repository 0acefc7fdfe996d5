#pragma once

// Conductors that a coarse grid of the preconditioner does not resolve. One source for the CPU (homogenize.hpp) and
// CUDA devices.
//
// Conductors far smaller than a grid's cells, if kept as conductors, slow CG down
// (docs/measurements/negative-results.json). Their effect on the field at the scale of the cells is known. Floating
// disks that fill a fraction f of the area are a medium of permittivity (1 + f) / (1 - f), which carries their charge
// (Maxwell Garnett 1904, in two dimensions). A conductor with a given potential, or with the potential of distant ones,
// is a subgrid conductor. It exchanges flux with the four cells around it, like a well in reservoir simulation
// (Peaceman 1978). The conductance depends on the logarithm of its radius.

#include <cmath>
#include <numbers>

#include "solvers/laplace/cutcell/layout.hpp"
#include "solvers/laplace/cutcell/surface_links.hpp"

namespace lichtenberg::laplace {

/// Minimum radius (cells) of disks that a coarse grid resolves. `least_lone_radius`: disks that float alone (each with
/// its own unknown potential). `least_radius`: disks that share a potential with others or have a given one. The values
/// are empirical (docs/measurements/negative-results.json).
inline constexpr double least_lone_radius = 0.7, least_radius = 0.5;

/// Maximum width and height (cells) of a set of disks that becomes part of an effective medium. The disks are too small
/// for the coarse grid, and their potential is no unknown of it.
inline constexpr double least_extent = 1.5;

/// Minimum length (cells) of a resolved bar. A bar of this length covers a cell centre at any angle (covers()). Without
/// one it would have no link.
inline constexpr double least_bar_length = std::numbers::sqrt2;

/// Returns true if a coarse grid resolves the body: rings always, bars and closed curves from a minimum length and
/// disks from a minimum radius on. `body`: lengths in cells. `floats_alone`: the body shares its unknown potential with
/// no other body.
LICHTENBERG_HOST_DEVICE inline bool is_resolved(const Outline& body, bool floats_alone) {
  if (body.kind == Outline::Kind::ring) return true;
  if (body.kind == Outline::Kind::bar) return norm(body.end - body.centre) >= least_bar_length;
  if (body.kind == Outline::Kind::curve)
    return body.end.x < 0 || 2 * std::max(body.end.x, body.end.y) >= least_bar_length;
  return body.size >= (floats_alone ? least_lone_radius : least_radius);
}

/// Returns the disk by which a coarse grid represents an unresolved body. The radius for a bar or a closed curve is the
/// mean of its two half sides, as for the capacitance of an ellipse with these half axes.
LICHTENBERG_HOST_DEVICE inline Outline unresolved_disk(const Outline& body) {
  if (body.kind == Outline::Kind::curve) return {Outline::Kind::disk, body.centre, {}, 0.5 * (body.end.x + body.end.y)};
  if (body.kind != Outline::Kind::bar) return body;
  return {Outline::Kind::disk, 0.5 * (body.centre + body.end), {}, 0.25 * (norm(body.end - body.centre) + body.size)};
}

/// Computes the effective relative permittivity (1 + f) / (1 - f) of a cell that contains floating disks (Maxwell
/// Garnett in two dimensions). `fill`: area fraction f of the disks. The formula diverges at 1, so that f is limited to
/// 0.8.
LICHTENBERG_HOST_DEVICE inline float effective_permittivity(float fill) {
  constexpr float largest_fill = 0.8f;
  if (fill > largest_fill) fill = largest_fill;
  return (1 + fill) / (1 - fill);
}

/// Computes the conductance of the face between two cells, per depth and permittivity of the fluid. The two half cells
/// are in series, with the harmonic mean 2 a b / (a + b) of the relative permittivities a and b.
LICHTENBERG_HOST_DEVICE inline float face_conductance(float permittivity_a, float permittivity_b) {
  return 2 * permittivity_a * permittivity_b / (permittivity_a + permittivity_b);
}

/// Computes the fraction of a circle's circumference that lies inside the box; it is 1/2 for a centre on a side.
/// `centre`, `radius`: in cells. For a circle that meets two sides the fractions are multiplied, exact for a centre in
/// a corner.
LICHTENBERG_HOST_DEVICE inline double share_in_box(Vec2 centre, double radius, const Layout& box) {
  const double distance[4] = {centre.x, box.nx - centre.x, centre.y, box.ny - centre.y};
  double share = 1;
  for (const double d : distance)
    if (d < radius) share *= 1 - std::acos(at_least(d / radius, -1.0)) / std::numbers::pi;
  return share;
}

/// Computes the conductance between a subgrid conductor (a disk too small for the coarse grid) and the bilinear mean of
/// the four cells around it. Reservoir simulation treats wells in this way (Peaceman 1978). The result is 2 pi / ln(0.5
/// / radius), times the fraction of the disk's circumference in the box. `disk`: lengths in cells.
/// A source in one cell has the cell's potential at a distance of exp(-gamma) / sqrt 8 = 0.198 cells. This is
/// Peaceman's equivalent radius; gamma is Euler's constant. A source divided among four cells with weights w has it at
/// 0.198 exp(2 pi s). Here s is the sum of w_k w_l (G(0) - G(k - l)). The square lattice's G(0) - G is 1/4 for
/// neighbours and 1/pi across a diagonal. The mean of s over positions between the cells gives 0.5 cells. A lower bound
/// of 1.5 keeps the logarithm from zero for larger disks.
LICHTENBERG_HOST_DEVICE inline double subgrid_conductance(const Outline& disk, const Layout& box) {
  return 2 * std::numbers::pi / std::log(at_least(0.5 / disk.size, 1.5)) * share_in_box(disk.centre, disk.size, box);
}

/// Bilinear interpolation at a point: the four cells around it, their rows and their weights. A cell beyond a side of
/// the box is replaced by its mirror image in the box. Its weight changes sign at an electrode side.
struct Interpolation {
  /// Memory index (Layout) of each cell.
  std::ptrdiff_t cell[4];
  int row[4];
  /// Interpolation weights; their absolute values sum to 1.
  float weight[4];
};

/// Column i and row j of the lower left one of the four cells around a point. For a point in the box both are at least
/// -1, which is outside the box.
struct InterpolationBase {
  int i, j;
};
/// Computes the lower left one of the four cells whose centres surround the point p (in cells).
LICHTENBERG_HOST_DEVICE inline InterpolationBase interpolation_base(Vec2 p) {
  return {static_cast<int>(std::floor(p.x - 0.5)), static_cast<int>(std::floor(p.y - 0.5))};
}

/// Mirror image of a cell at the sides of the box, for boundary conditions. A cell within the box is its own image.
struct MirroredCell {
  int i, j;
  /// Factor of the image's potential: -1 beyond one electrode side (odd continuation), else +1.
  float sign = 1;

  /// Computes the cell of an nx x ny box that mirrors cell (i, j), which may lie outside by one row or column. Each
  /// electrode side between the two changes the sign; an insulating side does not. `electrode` [4]: whether the left,
  /// right, bottom and top side is an electrode.
  LICHTENBERG_HOST_DEVICE static MirroredCell of(int nx, int ny, int i, int j, const bool* electrode) {
    MirroredCell cell{i < 0 ? 0 : i < nx ? i : nx - 1, j < 0 ? 0 : j < ny ? j : ny - 1};
    if (i < 0 ? electrode[0] : i >= nx && electrode[1]) cell.sign = -cell.sign;
    if (j < 0 ? electrode[2] : j >= ny && electrode[3]) cell.sign = -cell.sign;
    return cell;
  }
};

/// Returns whether the left, right, bottom and top side of the box is an electrode (otherwise it is insulating).
inline std::array<bool, 4> electrodes(const LaplaceProblem& problem) {
  std::array<bool, 4> result;
  for (int side = 0; side < 4; ++side) result[side] = problem.sides[side].kind == Side::Kind::electrode;
  return result;
}

/// Computes the bilinear interpolation at the point p (in cells) of a grid: the four cells around p and their weights.
/// Cells beyond a side are mirrored, with opposite sign at an electrode. `electrode` [4]: whether the left, right,
/// bottom and top side is an electrode.
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
