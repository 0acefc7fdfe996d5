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
inline constexpr double least_extent = 2.0;

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

/// Flux from a cell into a thin conductor, a disk much smaller than it, per potential difference: the cell's mean
/// potential is that at a distance of 0.208 cells (Peaceman's equivalent radius). For a disk that is not, the logarithm
/// is kept from zero.
LICHTENBERG_HOST_DEVICE inline double thin_conductance(double radius) {
  return 2 * std::numbers::pi / std::log(at_least(0.208 / radius, 1.5));
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

/// `electrode`: by SideIndex.
LICHTENBERG_HOST_DEVICE inline Interpolation interpolate(const Layout& at, Vec2 p, const bool* electrode) {
  const double x = p.x - 0.5, y = p.y - 0.5;
  const InterpolationBase base = interpolation_base(p);
  Interpolation result;
  for (int k = 0; k < 4; ++k) {
    int i = base.i + k % 2, j = base.j + k / 2;
    double weight = (k % 2 ? x - base.i : 1 - x + base.i) * (k / 2 ? y - base.j : 1 - y + base.j);
    if (i < 0 && electrode[0]) weight = -weight;
    if (i >= at.nx && electrode[1]) weight = -weight;
    if (j < 0 && electrode[2]) weight = -weight;
    if (j >= at.ny && electrode[3]) weight = -weight;
    i = i < 0 ? 0 : i < at.nx ? i : at.nx - 1;
    j = j < 0 ? 0 : j < at.ny ? j : at.ny - 1;
    result.cell[k] = at(i, j);
    result.row[k] = j;
    result.weight[k] = static_cast<float>(weight);
  }
  return result;
}

}  // namespace lichtenberg::laplace
