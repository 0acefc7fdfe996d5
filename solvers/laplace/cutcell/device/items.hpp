#pragma once

#include <array>
#include <cstdint>

#include "solvers/laplace/cutcell/cell_owner.hpp"
#include "solvers/laplace/cutcell/medium.hpp"

namespace lichtenberg::laplace::device {

/// Kinds of items in the lists of a grid. The device counts the items; until the end of a solve the host has only the
/// capacities of their arrays.
struct Items {
  enum Kind {
    strips,
    covered,
    links,
    boundary,
    direct_links,
    /// Direct links of bodies that cover no cell.
    without_cells,
    newly_absorbed,
    subgrid_conductors,
    floating_subgrid_conductors,
    /// 1 if any group has an unknown potential.
    unknown_groups,
    /// On a small grid: groups with an unknown potential.
    own_groups,
    /// Links (conductances) between groups (bodies with one potential) that arise where the V-cycle eliminates
    /// near-surface cells (bound.hpp).
    joined_links,
    /// On the finest grid: 1 if any direct link requires clusters (groups solved together).
    strong_links,
    /// Unknowns of the coarsest grid.
    coarse_unknowns,
    kinds
  };
};
using Numbers = std::array<int, Items::kinds>;

/// Numbers of items in a strip (part of a row of cells): covered cells, links to fluid cells, boundary cells (fluid
/// cells next to a conductor), direct links (gap conductances).
struct Counts {
  int covered = 0, links = 0, boundary = 0, direct_links = 0;
  LICHTENBERG_HOST_DEVICE friend Counts operator+(Counts a, Counts b) {
    return {a.covered + b.covered, a.links + b.links, a.boundary + b.boundary, a.direct_links + b.direct_links};
  }
};

/// Direct link of a body to another body or to an electrode side, without a fluid cell between them: the conductance of
/// their gap. A link of two bodies is listed once for each of them, as `own`.
struct DirectLink {
  enum class Kind : std::uint8_t {
    /// Link across `side` of the own cell `slot`, behind which lies the other body's cell or an electrode side.
    face,
    /// Link of a disk without a cell to the body that owns the cell of the disk's centre.
    shared_cell,
    /// A subgrid conductor (a body too small for the grid), and a body that has the `corner`-th of the four cells
    /// around it.
    subgrid_conductor,
    /// A link of a subgrid conductor, taken from the finest grid: direct link number `slot`, or joined link -1 -
    /// `slot`.
    inherited,
    /// Both bodies have links to a near-surface cell that the V-cycle eliminates; only in the V-cycle.
    eliminated_cell,
  };
  /// Body that lists the link.
  int own;
  /// Other body; or -1 - k for the electrode face k in the order of ProblemView::side_potential.
  int other;
  /// Memory index of the own cell for Kind::face, or number of an inherited link.
  int slot;
  Kind kind;
  std::uint8_t side, corner;
  /// For a shared cell or a subgrid conductor: whether the own body has the cell.
  bool own_has_cell;
  double conductance;
  /// Derivative of the conductance with respect to the own body's position (per cell width).
  Vec2 gradient;

  /// Returns the value of `other` for an electrode face.
  LICHTENBERG_HOST_DEVICE static constexpr int electrode_face(int face) { return -1 - face; }
  /// Returns true if the link (gap conductance) leads to an electrode side of the box.
  LICHTENBERG_HOST_DEVICE bool is_to_electrode() const { return other < 0; }
  /// Returns the index of the electrode face in ProblemView::side_potential.
  LICHTENBERG_HOST_DEVICE int face() const { return -1 - other; }
};

/// End of a link (conductance) from a fluid cell at a conductor: the body, and a number from 0 to 3. The number is the
/// cell's side towards the body. For a subgrid conductor (a body too small for the grid) it is the cell's place among
/// the four cells around the body. One integer stores both: 4 body + side, or -1 - (4 body + corner).
class LinkEnd {
 public:
  /// Makes the end of a link (conductance) from a fluid cell to a body across a side of the cell.
  LICHTENBERG_HOST_DEVICE static constexpr LinkEnd at_side(int body, int side) { return LinkEnd(4 * body + side); }
  /// Makes the end of a link (conductance) from a fluid cell to a subgrid conductor, a body too small for the grid.
  /// `corner`: number of the cell among the four around the body.
  LICHTENBERG_HOST_DEVICE static constexpr LinkEnd at_subgrid_conductor(int body, int corner) {
    return LinkEnd(-1 - (4 * body + corner));
  }
  /// Returns true if the body is a subgrid conductor (a body too small for the grid).
  LICHTENBERG_HOST_DEVICE constexpr bool is_subgrid_conductor() const { return code_ < 0; }
  /// Returns the index of the body at which the link ends.
  LICHTENBERG_HOST_DEVICE constexpr int body() const { return (code_ < 0 ? -1 - code_ : code_) / 4; }
  /// Returns the side of the fluid cell towards the body; not for a subgrid conductor (a body too small for the grid).
  LICHTENBERG_HOST_DEVICE constexpr int side() const { return code_ % 4; }
  /// Returns the number of the fluid cell among the four around a subgrid conductor (a body too small for the grid).
  LICHTENBERG_HOST_DEVICE constexpr int corner() const { return (-1 - code_) % 4; }

 private:
  LICHTENBERG_HOST_DEVICE constexpr explicit LinkEnd(int code) : code_(code) {}
  int code_;
};

/// Numbers of items of a body without cells: its direct links (gap conductances), 1 if it is a subgrid conductor, and 1
/// if that conductor floats. A subgrid conductor is a body too small for the grid.
struct WithoutCells {
  int direct_links = 0, subgrid_conductors = 0, floating_subgrid_conductors = 0;
  LICHTENBERG_HOST_DEVICE friend WithoutCells operator+(WithoutCells a, WithoutCells b) {
    return {a.direct_links + b.direct_links, a.subgrid_conductors + b.subgrid_conductors,
            a.floating_subgrid_conductors + b.floating_subgrid_conductors};
  }
};

/// Bodies of one group (with a common potential) between the same four cells of a coarse grid that does not resolve
/// them, treated as one point. `share`: parts of their area or conductance in the four cells, lower left and right,
/// upper left and right. For a group that the grid's medium absorbs, the shares are interpolation weights.
struct HomogenizedPoint {
  int group;
  float share[4];
  /// Adds the shares of another point; the group of bodies stays.
  LICHTENBERG_HOST_DEVICE HomogenizedPoint& operator+=(const HomogenizedPoint& other) {
    for (int k = 0; k < 4; ++k) share[k] += other.share[k];
    return *this;
  }
};

/// Homogenized points, sorted by bin. A bin is a set of four neighbouring cells, between which its points are
/// interpolated; the lower left cell gives its number. Sums over the points around a cell then always have the same
/// order.
struct Bins {
  /// Index of each bin's first point, with one more at the end.
  int* start;
  /// Group and shares of each point.
  HomogenizedPoint* points;
  /// Groups or bodies, sorted by bin.
  int* item;
};
/// Returns the number of bins of a grid (one for each set of four neighbouring cells, border included).
LICHTENBERG_HOST_DEVICE inline int bins_of(const Layout& at) { return (at.nx + 1) * (at.ny + 1); }
/// Returns the lower left of the four cells of a bin (Bins). Its indices start at -1, outside the box.
LICHTENBERG_HOST_DEVICE inline InterpolationBase base_of_bin(const Layout& at, int bin) {
  return {bin % (at.nx + 1) - 1, bin / (at.nx + 1) - 1};
}
/// Returns the bin of the point p (in cells): the number of the set of four cells around it.
LICHTENBERG_HOST_DEVICE inline int bin_of(const Layout& at, Vec2 p) {
  const InterpolationBase base = interpolation_base(p);
  const int i = base.i < -1 ? -1 : base.i < at.nx ? base.i : at.nx - 1;
  const int j = base.j < -1 ? -1 : base.j < at.ny ? base.j : at.ny - 1;
  return (j + 1) * (at.nx + 1) + i + 1;
}

/// Link from a boundary cell (a fluid cell next to a conductor) to a group (bodies with one potential), in single
/// precision for the V-cycle.
struct Coupling {
  /// Conductance; 0: no link.
  float conductance;
  int group;
};

}  // namespace lichtenberg::laplace::device
