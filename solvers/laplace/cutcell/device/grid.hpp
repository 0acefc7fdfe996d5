#pragma once

#include <array>
#include <cstdint>

#include "solvers/laplace/cutcell/cell_owner.hpp"
#include "solvers/laplace/cutcell/layout.hpp"
#include "solvers/laplace/cutcell/medium.hpp"
#include "solvers/laplace/cutcell/surface_links.hpp"
#include "solvers/parallel/array.hpp"
#include "solvers/parallel/host_executor.hpp"

namespace lichtenberg::laplace::device {

/// Sets of groups that coarse grids treat as one (../agglomerates.hpp); null: each group is its own set.
struct SetsView {
  const int* first_group;      ///< a set's first group
  const int *start, *group;    ///< by first group: its set's groups
  const int *is_alone, *held;  ///< by group: whether its set is one floating body; Agglomerates::is_grounded
  bool operator==(const SetsView&) const = default;
};

/// Couplings between groups (LaplaceProblem::couplings) as conductances, listed for each floating group.
struct CouplingView {
  const int *start, *other;  ///< by group, with one more at the end; groups. Null: none
  const double* conductance;
  const double* to_given;  ///< the sum of those to given potentials
  bool only_ground;        ///< all given potentials are those of coupled groups
  bool operator==(const CouplingView&) const = default;
};

/// Bodies, groups and sides of a problem, for all grids. Bodies are sorted by group ("rank"), so that the items of a
/// body or a group are contiguous.
struct ProblemView {
  int bodies;
  int groups;  ///< capacity; groups after the problem's own have no bodies and a given potential
  Vec2 size;
  double permittivity;
  bool electrode[4];
  bool grounded;
  int faces;                     ///< entries of `side_potential` a side
  const double* side_potential;  ///< V, on the finest grid's faces, by side and face
  const Outline* shape;          ///< by body, in metres
  const int* group_of;           ///< by body
  const int* body_at;            ///< by rank
  const int* rank_of;            ///< by body
  const int* first_rank;         ///< by group, with one more at the end
  const int* floating;           ///< by group
  const double* charge;          ///< C/m, by group
  const double* potential;       ///< V, by group, of fixed ones
  SetsView sets;
  CouplingView couplings;

  /// Number of a group's bodies, and the t-th of them.
  LICHTENBERG_HOST_DEVICE int members(int g) const { return first_rank[g + 1] - first_rank[g]; }
  LICHTENBERG_HOST_DEVICE int member(int g, int t) const { return body_at[first_rank[g] + t]; }
  bool operator==(const ProblemView&) const = default;
};

/// Kinds of items that a grid holds. The device counts them; the host has only the capacities of their arrays until the
/// end of a solve.
struct Items {
  enum Kind {
    strips,
    covered,
    links,
    boundary,
    direct_links,
    without_cells,  ///< direct links of bodies that cover no cell
    newly_absorbed,
    subgrid_conductors,
    floating_subgrid_conductors,
    unknown_groups,   ///< 1 if any group has an unknown potential
    own_groups,       ///< on a small grid: groups with an unknown potential
    joined_links,     ///< links made by the elimination of near-surface cells (bound.hpp)
    strong_links,     ///< on the finest grid: 1 if any direct link requires clusters
    coarse_unknowns,  ///< of the coarsest grid
    kinds
  };
};
using Numbers = std::array<int, Items::kinds>;

/// Numbers of items in a strip of cells.
struct Counts {
  int covered = 0, links = 0, boundary = 0, direct_links = 0;
  LICHTENBERG_HOST_DEVICE friend Counts operator+(Counts a, Counts b) {
    return {a.covered + b.covered, a.links + b.links, a.boundary + b.boundary, a.direct_links + b.direct_links};
  }
};

/// Link of a body to another body, or to an electrode side, with no fluid cell between them. A link of two bodies is
/// listed once for each.
struct DirectLink {
  enum class Kind : std::uint8_t {
    face,         ///< `side` of the own cell `slot`: the other body's cell is behind it, or an electrode side
    shared_cell,  ///< one of the two covers no cell's centre and lies in a cell of the other
    /// A subgrid conductor, and a body that has the `corner`-th of the four cells around it.
    subgrid_conductor,
    /// With a subgrid conductor: the finest grid's direct link number `slot`, or joined link -1 - `slot`.
    inherited,
    eliminated_cell,  ///< both have strong links to a cell that the cycle eliminates: a link in the cycle alone
  };
  int own;  ///< body
  /// Body; or -1 - the electrode side's face, as ProblemView::side_potential counts them.
  int other;
  int slot;  ///< this and `side` only of Kind::face
  Kind kind;
  std::uint8_t side, corner;
  bool own_has_cell;  ///< of a shared cell or a subgrid conductor: whether the own body has the cell
  double conductance;
  Vec2 gradient;  ///< of the conductance with respect to the own body's position, per cell

  LICHTENBERG_HOST_DEVICE static constexpr int electrode_face(int face) { return -1 - face; }
  LICHTENBERG_HOST_DEVICE bool is_to_electrode() const { return other < 0; }
  LICHTENBERG_HOST_DEVICE int face() const { return -1 - other; }
};

/// End of a link from a fluid cell: the body, and either the cell's side or, for a subgrid conductor, which of the four
/// cells around it the cell is. One integer: 4 body + side, or -1 - (4 body + corner).
class LinkEnd {
 public:
  LICHTENBERG_HOST_DEVICE static constexpr LinkEnd at_side(int body, int side) { return LinkEnd(4 * body + side); }
  LICHTENBERG_HOST_DEVICE static constexpr LinkEnd at_subgrid_conductor(int body, int corner) {
    return LinkEnd(-1 - (4 * body + corner));
  }
  LICHTENBERG_HOST_DEVICE constexpr bool is_subgrid_conductor() const { return code_ < 0; }
  LICHTENBERG_HOST_DEVICE constexpr int body() const { return (code_ < 0 ? -1 - code_ : code_) / 4; }
  LICHTENBERG_HOST_DEVICE constexpr int side() const { return code_ % 4; }           ///< not of a subgrid conductor
  LICHTENBERG_HOST_DEVICE constexpr int corner() const { return (-1 - code_) % 4; }  ///< of a subgrid conductor

 private:
  LICHTENBERG_HOST_DEVICE constexpr explicit LinkEnd(int code) : code_(code) {}
  int code_;
};

/// Numbers of items of a body without cells: direct links to bodies with cells; whether it is a subgrid conductor;
/// whether that floats.
struct WithoutCells {
  int direct_links = 0, subgrid_conductors = 0, floating_subgrid_conductors = 0;
  LICHTENBERG_HOST_DEVICE friend WithoutCells operator+(WithoutCells a, WithoutCells b) {
    return {a.direct_links + b.direct_links, a.subgrid_conductors + b.subgrid_conductors,
            a.floating_subgrid_conductors + b.floating_subgrid_conductors};
  }
};

/// Homogenized point: its group, and its shares in the four cells of its bin: lower left and right, upper left and
/// right.
struct HomogenizedPoint {
  int group;
  float share[4];
  /// Adds the shares; the group stays.
  LICHTENBERG_HOST_DEVICE HomogenizedPoint& operator+=(const HomogenizedPoint& other) {
    for (int k = 0; k < 4; ++k) share[k] += other.share[k];
    return *this;
  }
};

/// Points in the plane, sorted by the lower left one of the four cells between which they are interpolated. Sums over
/// the points of a cell then always have the same order.
struct Bins {
  int* start;                ///< first point of each bin, with one more at the end
  HomogenizedPoint* points;  ///< by point
  int* item;                 ///< groups or bodies, sorted by bin
};
LICHTENBERG_HOST_DEVICE inline int bins_of(const Layout& at) { return (at.nx + 1) * (at.ny + 1); }
/// Returns the lower left of the four cells of a bin (Bins). Its indices begin at -1, outside the box.
LICHTENBERG_HOST_DEVICE inline InterpolationBase base_of_bin(const Layout& at, int bin) {
  return {bin % (at.nx + 1) - 1, bin / (at.nx + 1) - 1};
}
LICHTENBERG_HOST_DEVICE inline int bin_of(const Layout& at, Vec2 p) {
  const InterpolationBase base = interpolation_base(p);
  const int i = base.i < -1 ? -1 : base.i < at.nx ? base.i : at.nx - 1;
  const int j = base.j < -1 ? -1 : base.j < at.ny ? base.j : at.ny - 1;
  return (j + 1) * (at.nx + 1) + i + 1;
}

/// Link of a boundary cell for the V-cycle.
struct Coupling {
  float conductance;  ///< 0: no link
  int group;
};

struct ClusterView;
struct Extent;

/// Arrays by body.
struct BodyArrays {
  Outline* outline;
  int* present;     ///< 1: covers a cell
  int* cell_owner;  ///< of a body that covers no cell centre: the body whose cell contains it, or -1
  int* resolved;
};

/// Homogenized bodies of a grid that has a medium: groups without an unknown potential, and points of their bodies,
/// sorted by bin. Bodies of one group in one bin are one point.
struct MediumArrays {
  int* absorbed;         ///< by group
  Vec2* centre;          ///< by group
  Extent* extent;        ///< by group, then by the set's first group; null: no sets
  Bins absorbed_bodies;  ///< the start, and likewise of subgrid conductors, in one array
  Bins subgrid_conductors;
  Bins absorbed_groups;  ///< groups that the next finer grid does not absorb
  int* point;            ///< by body: number of the point whose first body it is, or -1
  float* permittivity;   ///< by slot
  float *east, *north;   ///< by slot: conductance of a cell's face to the next cell, 0 if either is covered
};

/// Arrays by slot. A boundary cell is a fluid cell with a link.
struct CellArrays {
  CellOwner* owner;
  float* inverse_diagonal;  ///< 0 in covered cells and padding
};

/// Cells of the bodies' bounding boxes in strips of one row.
struct StripArrays {
  int* start;      ///< by rank
  Counts* counts;  ///< by strip, summed over the strips before
};

/// Covered cells, sorted by body.
struct CoveredArrays {
  int *slot, *group;
};

/// Links of a body to a fluid cell, sorted by body.
struct LinkArrays {
  int* slot;
  LinkEnd* end;
  int* group;
  double* conductance;
  Vec2* gradient;          ///< on the finest grid only, as the next two
  int* partner_group;      ///< of the body on the opposite side of a narrow gap's cell, or -1
  Vec2* partner_gradient;  ///< of that body's link with respect to this link's body
};

struct BoundaryArrays {
  int* slot;
  int* link;  ///< by side (side * capacity[Items::boundary] + k), -1: none
  double* diagonal;
  Coupling* coupling;  ///< by boundary cell and side: 4 k + side
};

/// Near-surface cells of a grid on which the cycle eliminates them.
struct BoundArrays {
  int* is_eliminated;  ///< by boundary cell
  float* share;        ///< by link: conductance / diagonal of its cell if the cell is bound, else 0
  double* kept;        ///< by link of an eliminated cell: contribution to its group's diagonal
  DirectLink* joined;  ///< sorted by body
  int* joined_start;   ///< by rank
};

/// Direct links, sorted by body.
struct DirectArrays {
  DirectLink* link;
  int* start;  ///< by rank
};

/// Links of the finest grid that a coarse grid keeps: direct links, and links (`joined`) that the elimination of
/// near-surface cells has made. Null on grids that keep none.
struct InheritedArrays {
  const DirectLink *link, *joined;
  const int *link_start, *joined_start;  ///< by rank
};

/// Pieces of the groups' links and, after them, of the groups' covered cells. Partial sums run over pieces, so that a
/// large group is no long serial sum.
struct PieceArrays {
  int capacity;  ///< in pieces
  int* start;    ///< 2 groups + 1
  int *begin, *end, *segment;
  int* done;        ///< 2 groups
  double* partial;  ///< by piece: partial sums in double precision
};

struct GroupArrays {
  int* own;                           ///< of a small grid: groups with an unknown potential
  const ClusterView* clusters;        ///< groups that are relaxed together (relax_clusters.hpp); null: none
  const ClusterView* exact_clusters;  ///< finest grid with couplings: all coupled or linked groups
  double* diagonal;                   ///< 0: fixed, or a group without any link
  double* cycle_diagonal;             ///< likewise, with near-surface cells eliminated
  float* inverse_diagonal;            ///< 1 / cycle_diagonal
};

/// The V-cycle's vectors.
struct CycleArrays {
  float *v, *f;                                      ///< by slot; v: null on the finest grid
  float *phi, *phi_down, *phi_next, *charge, *flux;  ///< by group
  double* group_rhs;                                 ///< likewise, where there may be clusters
  float* partial;                                    ///< by piece
};

/// Arrays of a grid for kernels. Sides of cells and of the box are numbered by SideIndex; side ^ 1 is the opposite one.
struct GridView {
  Layout layout;
  double h;
  LinkFormula formula;
  bool finest;
  bool has_medium;  ///< some bodies are smaller than this grid resolves (../medium.hpp)
  bool binds;       ///< the cycle eliminates near-surface cells (bound.hpp)

  Numbers capacity;  ///< the number of items that arrays have memory for
  int* number;       ///< by Items::Kind; 0 for all lists if one exceeds its capacity
  int* required;     ///< by Items::Kind: the number of items found

  BodyArrays bodies;
  MediumArrays medium;
  CellArrays cells;
  StripArrays strips;
  CoveredArrays covered;
  LinkArrays links;
  BoundaryArrays boundary;
  BoundArrays bound;
  DirectArrays direct;
  InheritedArrays inherited;
  PieceArrays pieces;
  GroupArrays groups;
  CycleArrays cycle;

  LICHTENBERG_HOST_DEVICE const Counts& before(int rank) const {
    const int start = strips.start[rank], end = number[Items::strips];
    return strips.counts[start < end ? start : end];
  }
  LICHTENBERG_HOST_DEVICE int link_start(int rank) const { return before(rank).links; }
  LICHTENBERG_HOST_DEVICE int covered_start(int rank) const { return before(rank).covered; }
  LICHTENBERG_HOST_DEVICE int boundary_link_of(int k, int side) const {
    return boundary.link[side * capacity[Items::boundary] + k];
  }
  /// First direct link of a group, and their number.
  LICHTENBERG_HOST_DEVICE int first_direct_link(const ProblemView& problem, int g) const {
    return direct.start[problem.first_rank[g]];
  }
  LICHTENBERG_HOST_DEVICE int direct_links_of(const ProblemView& problem, int g) const {
    return first_direct_link(problem, g + 1) - first_direct_link(problem, g);
  }
  /// Returns the number of a group's direct links and links made by eliminated cells, which the cycle treats as equal.
  LICHTENBERG_HOST_DEVICE int cycle_links_of(const ProblemView& problem, int g) const {
    return direct_links_of(problem, g) + joined_before(problem, g + 1) - joined_before(problem, g);
  }
  /// Returns the t-th of the links that cycle_links_of() counts.
  LICHTENBERG_HOST_DEVICE const DirectLink& cycle_link(const ProblemView& problem, int g, int t) const {
    const int n = direct_links_of(problem, g);
    return t < n ? direct.link[first_direct_link(problem, g) + t] : bound.joined[joined_before(problem, g) + t - n];
  }
  LICHTENBERG_HOST_DEVICE int joined_before(const ProblemView& problem, int g) const {
    return may_have(Items::joined_links) ? bound.joined_start[problem.first_rank[g]] : 0;
  }
  /// Returns true if the k-th entry of a vector, by slot and then by group, is an unknown.
  LICHTENBERG_HOST_DEVICE bool is_unknown(int k) const {
    const int size = static_cast<int>(layout.size());
    return k < size ? cells.inverse_diagonal[k] > 0 : groups.diagonal[k - size] > 0;
  }
  LICHTENBERG_HOST_DEVICE bool may_have(Items::Kind kind) const { return capacity[kind] > 0; }
  /// Returns true if groups may be linked to each other.
  LICHTENBERG_HOST_DEVICE bool may_link_groups() const {
    return groups.clusters || may_have(Items::direct_links) || may_have(Items::joined_links);
  }
  /// Pieces of the groups' links, and of their covered cells.
  LICHTENBERG_HOST_DEVICE parallel::SegmentPieces link_pieces(const ProblemView& problem) const {
    return {problem.groups, pieces.capacity, pieces.start, pieces.begin, pieces.end, pieces.segment, 0, pieces.done};
  }
  LICHTENBERG_HOST_DEVICE parallel::SegmentPieces covered_pieces(const ProblemView& problem) const {
    const int n = problem.groups;
    return {n, pieces.capacity, pieces.start + n, pieces.begin, pieces.end, pieces.segment, n, pieces.done + n};
  }
};

/// Calls f(k) for each item of a kind.
template <class Executor, class F>
void for_each_item(const Executor& run, const GridView& grid, Items::Kind kind, F f) {
  const int* number = grid.number + kind;
  run.for_each(grid.capacity[kind], [=] LICHTENBERG_HOST_DEVICE(int k) {
    if (k < *number) f(k);
  });
}

constexpr int strip_width = 32;
constexpr int piece_length = 128;

LICHTENBERG_HOST_DEVICE inline int slot_of(const Layout& at, int i, int j) { return static_cast<int>(at(i, j)); }
/// Slots of a cell's four neighbours, which have the other colour.
struct Neighbours {
  int west, east, south, north;
};
/// Neighbours by row and column including padding: row j + 1, column k + pad.
LICHTENBERG_HOST_DEVICE inline Neighbours neighbours(const Layout& at, int colour, int row, int column) {
  const int stride = static_cast<int>(at.stride);
  const int beside = (1 - colour) * static_cast<int>(at.colour_size()) + row * stride + column;
  const int east = beside + Layout::parity(colour, row - 1);
  return {east - 1, east, beside - stride, beside + stride};
}
LICHTENBERG_HOST_DEVICE inline Neighbours neighbours(const Layout& at, int slot) {
  const int colour_size = static_cast<int>(at.colour_size()), stride = static_cast<int>(at.stride);
  const int colour = slot >= colour_size;
  const int inner = slot - colour * colour_size;
  return neighbours(at, colour, inner / stride, inner % stride);
}

/// Returns the last of the n + 1 ascending entries that is at most `value`.
LICHTENBERG_HOST_DEVICE inline int segment_of(const int* start, int n, int value) {
  int low = 0, high = n;
  while (high - low > 1) {
    const int middle = (low + high) / 2;
    (start[middle] <= value ? low : high) = middle;
  }
  return low;
}

/// Assigns a cell to a body: the lowest index wins; fluid, -1, counts as the highest.
LICHTENBERG_HOST_DEVICE inline void claim(CellOwner* owner, int body) {
#ifdef __CUDA_ARCH__
  atomicMin(reinterpret_cast<unsigned*>(owner), static_cast<unsigned>(body));
#else
  if (owner->is_fluid() || body < owner->body()) *owner = CellOwner::by(body);
#endif
}

}  // namespace lichtenberg::laplace::device
