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

/// Agglomerates as device pointers: sets of groups (bodies with one potential) that coarse grids treat as one
/// (../agglomerates.hpp). Null pointers: each group is its own set.
struct SetsView {
  /// By group: first group of its set.
  const int* first_group;
  /// Groups sorted by set; `start`: by a set's first group, the index of its groups in `group`.
  const int *start, *group;
  /// By group. `is_alone`: whether its set is one floating body; `held`: whether its set is grounded
  /// (Agglomerates::is_grounded).
  const int *is_alone, *held;
  bool operator==(const SetsView&) const = default;
};

/// Couplings (lumped capacitances) between groups as conductances per permittivity, in a list for each floating group
/// (device pointers). A group is a set of bodies with one potential.
struct CouplingView {
  /// `start` [groups + 1]: index of a group's first entry in `other` and `conductance`; null: no couplings. `other`:
  /// group at the other end.
  const int *start, *other;
  const double* conductance;
  /// Sum of all conductances to groups of given potential (one value).
  const double* to_given;
  /// True if all given potentials are those of coupled groups, so that only couplings ground the field.
  bool only_ground;
  bool operator==(const CouplingView&) const = default;
};

/// Bodies, groups (bodies with one potential) and sides of a problem as device pointers, common to all grids. Bodies
/// are sorted by group; a body's place in this order is its rank. Lists of links and of covered cells follow this
/// order, so that the entries of a body or a group are contiguous.
struct ProblemView {
  int bodies;
  /// Number of groups that the arrays have memory for. Groups after the problem's own have no bodies and a given
  /// potential.
  int groups;
  Vec2 size;
  double permittivity;
  bool electrode[4];
  /// False if no potential is given, so that potentials are determined up to a constant.
  bool grounded;
  /// Number of entries of `side_potential` for each side.
  int faces;
  /// Potential (V) on the finest grid's faces, by side and face.
  const double* side_potential;
  /// Shape by body, lengths in metres.
  const Outline* shape;
  /// Group of each body.
  const int* group_of;
  /// Body of each rank.
  const int* body_at;
  /// Rank of each body.
  const int* rank_of;
  /// [groups + 1] rank of each group's first body.
  const int* first_rank;
  /// 1 if a group's potential is unknown (given charge), else 0.
  const int* floating;
  /// Charge (C/m) by group.
  const double* charge;
  /// Given potential (V) by group; 0 for floating groups.
  const double* potential;
  SetsView sets;
  CouplingView couplings;

  /// Returns the number of bodies of group g. A group is a set of bodies with one potential.
  LICHTENBERG_HOST_DEVICE int members(int g) const { return first_rank[g + 1] - first_rank[g]; }
  /// Returns the t-th body of group g. A group is a set of bodies with one potential.
  LICHTENBERG_HOST_DEVICE int member(int g, int t) const { return body_at[first_rank[g] + t]; }
  bool operator==(const ProblemView&) const = default;
};

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
    /// Links between groups, made by the elimination of near-surface cells (bound.hpp).
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
  /// Returns the index of the body.
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

/// Points in the plane, sorted by bin. A bin is a set of four neighbouring cells, between which its points are
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

struct ClusterView;
struct Extent;

/// Arrays by body on one grid (device pointers).
struct BodyArrays {
  Outline* outline;
  /// 1 if the body covers a cell or needs none, because the grid does not resolve it.
  int* present;
  /// For a disk without a cell, the body that owns the cell of its centre; otherwise -1.
  int* cell_owner;
  /// 1 if the grid resolves the body.
  int* resolved;
};

/// Arrays of a coarse grid with an effective medium: bodies too small for the grid, as points sorted by bin (four
/// neighbouring cells). An absorbed group has no unknown potential on the grid. Bodies of one group in one bin are one
/// point. A group is a set of bodies with one potential.
struct MediumArrays {
  /// By group: 1 if the medium absorbs it.
  int* absorbed;
  /// By group: centre of its extent (cells).
  Vec2* centre;
  /// Extents by group, followed by those by a set's first group; null without sets.
  Extent* extent;
  /// Bodies of absorbed groups. Its array `start` continues with that of the subgrid conductors.
  Bins absorbed_bodies;
  Bins subgrid_conductors;
  /// Absorbed groups that the next finer grid does not absorb.
  Bins absorbed_groups;
  /// By body: number of the point whose first body it is, or -1.
  int* point;
  /// By slot: effective relative permittivity.
  float* permittivity;
  /// By slot: conductance of a cell's face to the cell on the right and above, 0 if either is covered.
  float *east, *north;
};

/// Arrays by slot (memory index of a cell). A boundary cell is a fluid cell next to a conductor.
struct CellArrays {
  CellOwner* owner;
  /// 1 / (sum of conductances); 0 in covered cells and padding.
  float* inverse_diagonal;
};

/// Strips of the cells in the bodies' bounding boxes, each a part of one row.
struct StripArrays {
  /// By rank (order of bodies by group): index of the body's first strip.
  int* start;
  /// By strip: numbers of items in all strips before it.
  Counts* counts;
};

/// Covered cells (cells inside bodies), sorted by body: their slots (memory indices) and groups (bodies with one
/// potential).
struct CoveredArrays {
  int *slot, *group;
};

/// Links between a fluid cell and a conductor, sorted by body.
struct LinkArrays {
  int* slot;
  LinkEnd* end;
  int* group;
  double* conductance;
  /// Derivative of the conductance with respect to the body's position; this array and the next two on the finest grid
  /// only.
  Vec2* gradient;
  /// In a narrow gap of one cell: group of the body on the opposite side of the cell, or -1.
  int* partner_group;
  /// Derivative of the opposite body's link with respect to the position of this link's body.
  Vec2* partner_gradient;
};

/// Arrays by boundary cell (a fluid cell with a link to a conductor).
struct BoundaryArrays {
  int* slot;
  /// Index of the link on each side, at side * capacity[Items::boundary] + k for cell k; -1: none.
  int* link;
  /// Sum of the conductances of the cell's faces and links.
  double* diagonal;
  /// Links for the V-cycle, at 4 k + side for boundary cell k.
  Coupling* coupling;
};

/// Arrays for the near-surface cells that the V-cycle eliminates on this grid (Kron reduction).
struct BoundArrays {
  /// 1 if a boundary cell is eliminated.
  int* is_eliminated;
  /// By link: conductance / diagonal of its cell if the cell is eliminated, else 0.
  float* share;
  /// By link of an eliminated cell: its contribution to its group's diagonal (Schur complement).
  double* kept;
  /// Links between groups that the elimination makes, sorted by body.
  DirectLink* joined;
  /// By rank (order of bodies by group): index of the body's first joined link.
  int* joined_start;
};

/// Direct links between conductors (without a fluid cell between them), sorted by body.
struct DirectArrays {
  DirectLink* link;
  /// By rank (order of bodies by group): index of the body's first link.
  int* start;
};

/// Links of the finest grid that a coarse grid may keep: direct links (gap conductances), and links (`joined`) made by
/// the elimination of near-surface cells. Null pointers: the grid keeps none.
struct InheritedArrays {
  const DirectLink *link, *joined;
  /// By rank (order of bodies by group): index of the body's first link.
  const int *link_start, *joined_start;
};

/// Pieces of each group's list of links (conductances) and of its list of covered cells (inside conductors). Sums run
/// over pieces in parallel, so that the sum of a large group (bodies with one potential) is not serial.
struct PieceArrays {
  /// Number of pieces that the arrays have memory for.
  int capacity;
  /// [2 groups + 1] first piece of each group's links, then of each group's covered cells.
  int* start;
  /// By piece: its range in the list, and the number of its segment (a group's links or covered cells).
  int *begin, *end, *segment;
  /// [2 groups] counters of finished pieces, for each group's links, then for each group's covered cells.
  int* done;
  /// By piece: partial sums in double precision.
  double* partial;
};

/// Arrays by group (bodies with one potential) on one grid: diagonals of the groups' equations, and clusters (groups
/// solved together).
struct GroupArrays {
  /// On a small grid: list of the groups with an unknown potential.
  int* own;
  /// Clusters: groups that are relaxed together (relax_clusters.hpp); null: none.
  const ClusterView* clusters;
  /// On the finest grid with couplings: clusters of all coupled or linked groups; else null.
  const ClusterView* exact_clusters;
  /// Sum of the group's conductances without couplings; 0 for given potentials and groups without any link.
  double* diagonal;
  /// Diagonal after elimination of near-surface cells.
  double* cycle_diagonal;
  /// 1 / cycle_diagonal.
  float* inverse_diagonal;
};

/// Vectors of the V-cycle on one grid, in single precision.
struct CycleArrays {
  /// By slot: potentials and right-hand sides of cells. v is null on the finest grid.
  float *v, *f;
  /// By group: potentials (current, in the first half of the cycle, after a sweep), right-hand sides, fluxes from
  /// cells.
  float *phi, *phi_down, *phi_next, *charge, *flux;
  /// By group: right-hand sides in double precision, where there may be clusters.
  double* group_rhs;
  /// By piece: partial sums.
  float* partial;
};

/// Arrays of one grid as device pointers for kernels. Sides of cells and of the box are numbered by SideIndex; side ^ 1
/// is the opposite one.
struct GridView {
  Layout layout;
  double h;
  LinkFormula formula;
  bool finest;
  /// True if some bodies are smaller than this grid resolves (../medium.hpp).
  bool has_medium;
  /// True if the V-cycle eliminates near-surface cells on this grid (bound.hpp).
  bool binds;

  /// Number of items of each kind that arrays have memory for.
  Numbers capacity;
  /// By Items::Kind: number of items; 0 for all lists if one exceeds its capacity.
  int* number;
  /// By Items::Kind: number of items found.
  int* required;

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

  /// Returns the numbers of items of all bodies before the given rank (place in the order of bodies by group). A group
  /// is a set of bodies with one potential.
  LICHTENBERG_HOST_DEVICE const Counts& before(int rank) const {
    const int start = strips.start[rank], end = number[Items::strips];
    return strips.counts[start < end ? start : end];
  }
  /// Returns the index of the first link (conductance to a fluid cell) of the body at this rank. The rank is the body's
  /// index in the order of bodies by group.
  LICHTENBERG_HOST_DEVICE int link_start(int rank) const { return before(rank).links; }
  /// Returns the index of the first covered cell (inside a conductor) of the body at this rank. The rank is the body's
  /// index in the order of bodies by group.
  LICHTENBERG_HOST_DEVICE int covered_start(int rank) const { return before(rank).covered; }
  /// Returns the index of the link (conductance to a conductor) of boundary cell k on a side, or -1. A boundary cell is
  /// a fluid cell next to a conductor.
  LICHTENBERG_HOST_DEVICE int boundary_link_of(int k, int side) const {
    return boundary.link[side * capacity[Items::boundary] + k];
  }
  /// Returns the index of the first direct link of group g. A direct link is the conductance between two conductors
  /// without a fluid cell between them. A group is a set of bodies with one potential.
  LICHTENBERG_HOST_DEVICE int first_direct_link(const ProblemView& problem, int g) const {
    return direct.start[problem.first_rank[g]];
  }
  /// Returns the number of direct links (gap conductances) of group g. A group is a set of bodies with one potential.
  LICHTENBERG_HOST_DEVICE int direct_links_of(const ProblemView& problem, int g) const {
    return first_direct_link(problem, g + 1) - first_direct_link(problem, g);
  }
  /// Returns the number of a group's direct links (gap conductances) and of its links that the elimination of
  /// near-surface cells makes. The V-cycle treats both kinds equally. A group is a set of bodies with one potential.
  LICHTENBERG_HOST_DEVICE int cycle_links_of(const ProblemView& problem, int g) const {
    return direct_links_of(problem, g) + joined_before(problem, g + 1) - joined_before(problem, g);
  }
  /// Returns the t-th of the links between group g and other groups that cycle_links_of() counts. A group is a set of
  /// bodies with one potential.
  LICHTENBERG_HOST_DEVICE const DirectLink& cycle_link(const ProblemView& problem, int g, int t) const {
    const int n = direct_links_of(problem, g);
    return t < n ? direct.link[first_direct_link(problem, g) + t] : bound.joined[joined_before(problem, g) + t - n];
  }
  /// Returns the number of entries before group g (bodies with one potential) in the list of links that eliminated
  /// cells make. An eliminated cell is a fluid cell with a large conductance to a conductor.
  LICHTENBERG_HOST_DEVICE int joined_before(const ProblemView& problem, int g) const {
    return may_have(Items::joined_links) ? bound.joined_start[problem.first_rank[g]] : 0;
  }
  /// Returns true if the k-th entry of a vector, by slot (memory index) and then by group (bodies with one potential),
  /// is an unknown.
  LICHTENBERG_HOST_DEVICE bool is_unknown(int k) const {
    const int size = static_cast<int>(layout.size());
    return k < size ? cells.inverse_diagonal[k] > 0 : groups.diagonal[k - size] > 0;
  }
  /// Returns true if the grid has memory for items of this kind. If false, its lists contain no such items.
  LICHTENBERG_HOST_DEVICE bool may_have(Items::Kind kind) const { return capacity[kind] > 0; }
  /// Returns true if groups (bodies with one potential) may be linked to each other, directly or by couplings (lumped
  /// capacitances).
  LICHTENBERG_HOST_DEVICE bool may_link_groups() const {
    return groups.clusters || may_have(Items::direct_links) || may_have(Items::joined_links);
  }
  /// Returns the pieces of the groups' lists of links (conductances to fluid cells), for parallel sums by group. A
  /// group is a set of bodies with one potential.
  LICHTENBERG_HOST_DEVICE parallel::SegmentPieces link_pieces(const ProblemView& problem) const {
    return {problem.groups, pieces.capacity, pieces.start, pieces.begin, pieces.end, pieces.segment, 0, pieces.done};
  }
  /// Returns the pieces of the groups' lists of covered cells (inside conductors), for parallel sums by group. A group
  /// is a set of bodies with one potential.
  LICHTENBERG_HOST_DEVICE parallel::SegmentPieces covered_pieces(const ProblemView& problem) const {
    const int n = problem.groups;
    return {n, pieces.capacity, pieces.start + n, pieces.begin, pieces.end, pieces.segment, n, pieces.done + n};
  }
};

/// Calls f(k) for each item k of a kind on the grid.
template <class Executor, class F>
void for_each_item(const Executor& run, const GridView& grid, Items::Kind kind, F f) {
  const int* number = grid.number + kind;
  run.for_each(grid.capacity[kind], [=] LICHTENBERG_HOST_DEVICE(int k) {
    if (k < *number) f(k);
  });
}

/// Maximum number of cells in a strip, a part of a row of a body's bounding box.
constexpr int strip_width = 32;
/// Maximum number of links (conductances) or covered cells (inside conductors) in a piece, the unit of a parallel sum.
constexpr int piece_length = 128;

/// Returns the memory index (slot) of cell (i, j) as int.
LICHTENBERG_HOST_DEVICE inline int slot_of(const Layout& at, int i, int j) { return static_cast<int>(at(i, j)); }
/// Slots (memory indices) of a cell's four neighbours, which have the other colour.
struct Neighbours {
  int west, east, south, north;
};
/// Returns the slots (memory indices) of a cell's neighbours from its colour, row and column including padding: row j +
/// 1, column k + pad.
LICHTENBERG_HOST_DEVICE inline Neighbours neighbours(const Layout& at, int colour, int row, int column) {
  const int stride = static_cast<int>(at.stride);
  const int beside = (1 - colour) * static_cast<int>(at.colour_size()) + row * stride + column;
  const int east = beside + Layout::parity(colour, row - 1);
  return {east - 1, east, beside - stride, beside + stride};
}
/// Returns the slots (memory indices) of the four neighbours of the cell at `slot`.
LICHTENBERG_HOST_DEVICE inline Neighbours neighbours(const Layout& at, int slot) {
  const int colour_size = static_cast<int>(at.colour_size()), stride = static_cast<int>(at.stride);
  const int colour = slot >= colour_size;
  const int inner = slot - colour * colour_size;
  return neighbours(at, colour, inner / stride, inner % stride);
}

/// Returns the index of the last of the first n entries of `start` (ascending) that is at most `value`, by bisection.
LICHTENBERG_HOST_DEVICE inline int segment_of(const int* start, int n, int value) {
  int low = 0, high = n;
  while (high - low > 1) {
    const int middle = (low + high) / 2;
    (start[middle] <= value ? low : high) = middle;
  }
  return low;
}

/// Assigns a cell to a body unless a body of lower index has it; fluid counts as the highest index. On a CUDA device
/// the operation is atomic.
LICHTENBERG_HOST_DEVICE inline void claim(CellOwner* owner, int body) {
#ifdef __CUDA_ARCH__
  atomicMin(reinterpret_cast<unsigned*>(owner), static_cast<unsigned>(body));
#else
  if (owner->is_fluid() || body < owner->body()) *owner = CellOwner::by(body);
#endif
}

}  // namespace lichtenberg::laplace::device
