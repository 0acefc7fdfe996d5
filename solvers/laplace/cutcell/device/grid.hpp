#pragma once

#include <cstdint>

#include "solvers/laplace/cutcell/device/items.hpp"
#include "solvers/laplace/cutcell/device/problem_view.hpp"
#include "solvers/parallel/array.hpp"
#include "solvers/parallel/host_executor.hpp"

namespace lichtenberg::laplace::device {

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
  /// By slot: potentials and right-hand sides of cells. On the finest grid v is the preconditioned residual.
  float *v, *f;
  /// By group: potentials (current, in the first half of the cycle, after a sweep), right-hand sides, fluxes from
  /// cells.
  float *phi, *phi_down, *phi_next, *charge, *flux;
  /// By group: right-hand sides in double precision, where there may be clusters.
  double* group_rhs;
  /// By piece: partial sums.
  float* partial;
};

/// Preconditioned residual z = M r (device pointers): in single precision by slot (memory index), in double precision
/// by group (bodies with one potential).
struct PreconditionedResidual {
  float* cell = nullptr;
  double* group = nullptr;
  long cells = 0;  ///< number of slots

  /// Returns the k-th entry, by slot and then by group.
  LICHTENBERG_HOST_DEVICE double operator[](long k) const { return k < cells ? cell[k] : group[k - cells]; }
};

/// Division of a grid's rows among the ranks of several devices (divided.hpp). Borders are multiples of 2^shift rows,
/// so that the borders on coarser grids are at the same heights.
struct RowDivision {
  int ranks = 1, shift = 0;
  /// Returns the first row of a rank of a grid with `ny` rows; `ny` for the rank behind the last.
  LICHTENBERG_HOST_DEVICE int border(int ny, int rank) const {
    return static_cast<int>(static_cast<long>(ny >> shift) * rank / ranks) << shift;
  }
};

/// Maximum number of cells in a strip, a part of a row of a body's bounding box.
constexpr int strip_width = 32;
/// Maximum number of links (conductances) or covered cells (inside conductors) in a piece, the unit of a parallel sum.
constexpr int piece_length = 128;

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
  /// Rows of all ranks. `layout.own` is those of this rank; on a grid that each rank computes it is all rows.
  RowDivision rows;
  /// Memory for values from each rank; null on one device.
  double* from_ranks;

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
    const int n = problem.groups, most = capacity[Items::links] / piece_length + n;
    return {n, most, pieces.start, pieces.begin, pieces.end, pieces.segment, 0, pieces.done};
  }
  /// Returns the pieces of the groups' lists of covered cells (inside conductors), for parallel sums by group. A group
  /// is a set of bodies with one potential.
  LICHTENBERG_HOST_DEVICE parallel::SegmentPieces covered_pieces(const ProblemView& problem) const {
    const int n = problem.groups, most = capacity[Items::covered] / piece_length + n;
    return {n, most, pieces.start + n, pieces.begin, pieces.end, pieces.segment, n, pieces.done + n};
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
