#pragma once

// Homogenized bodies of a coarse grid (../medium.hpp): groups that it absorbs, disks without cells, and the shares of
// both in the cells around them.

#include "solvers/laplace/cutcell/device/discretize.hpp"

namespace lichtenberg::laplace::device {

/// Bounding rectangle of the bodies of a group or of a set of groups (cells), and the number of bodies that the grid
/// resolves. A group is a set of bodies with one potential.
struct Extent {
  double low_x = infinite, low_y = infinite, high_x = -infinite, high_y = -infinite;
  double resolved = 0;  // number of resolved disks
  static constexpr double infinite = 1e300;
  LICHTENBERG_HOST_DEVICE Extent& operator+=(const Extent& other) {
    low_x = other.low_x < low_x ? other.low_x : low_x;
    low_y = other.low_y < low_y ? other.low_y : low_y;
    high_x = other.high_x > high_x ? other.high_x : high_x;
    high_y = other.high_y > high_y ? other.high_y : high_y;
    resolved += other.resolved;
    return *this;
  }
};

/// Device pointers for sorting items by integer keys: the key and the index of each item.
struct SortArrays {
  int *key, *index;  ///< of the items
};

/// Decision whether a group (bodies with one potential) becomes part of the grid's effective medium: its bodies then
/// only change the conductances of cells, and it has no unknown. `finer_absorbed`: the decisions on the next finer
/// grid; null: none absorbed.
struct Absorb {
  ProblemView problem;
  GridView grid;
  const int* finer_absorbed;
  SortArrays sort;
  /// Decides whether group g (bodies with one potential) becomes part of the grid's effective medium (cells whose
  /// conductances include small bodies without unknowns). Writes the group's sort key. `extent`: bounding rectangle of
  /// the agglomerate of g (SetsView).
  LICHTENBERG_HOST_DEVICE void operator()(int g, const Extent& extent) const {
    const double width = extent.high_x - extent.low_x, height = extent.high_y - extent.low_y;
    const bool held = problem.sets.held ? problem.sets.held[g] : !problem.floating[g];
    const bool absorbed = !held && extent.resolved == 0 && width <= least_extent && height <= least_extent;
    const bool newly = absorbed && !(finer_absorbed && finer_absorbed[g]);
    grid.medium.absorbed[g] = absorbed;
    grid.medium.centre[g] = {0.5 * (extent.low_x + extent.high_x), 0.5 * (extent.low_y + extent.high_y)};
    sort.key[g] = newly ? bin_of(grid.layout, grid.medium.centre[g]) : bins_of(grid.layout);
    sort.index[g] = g;
  }
};

/// Finds the groups (bodies with one potential) that become part of the grid's effective medium (cells whose
/// conductances include small bodies without unknowns). They belong to small floating agglomerates (SetsView) of bodies
/// that the grid does not resolve. `finer_absorbed`: the decisions on the next finer grid; null: none absorbed. `sort`:
/// receives the bin (the four cells around) of each group that this grid absorbs but the next finer grid does not.
template <class Executor>
void absorb_groups(const Executor& run, ProblemView problem, GridView grid, const int* finer_absorbed,
                   SortArrays sort) {
  const Absorb absorb{problem, grid, finer_absorbed, sort};
  run.sum_segments(
      problem.groups, [=] LICHTENBERG_HOST_DEVICE(int g) { return problem.members(g); },
      [=] LICHTENBERG_HOST_DEVICE(int g, int t) {
        const int body = problem.member(g, t);
        const Outline& outline = grid.bodies.outline[body];
        Extent extent;
        extent.resolved = grid.bodies.resolved[body];
        extent.low_x = outline.centre.x - outline.size;
        extent.low_y = outline.centre.y - outline.size;
        extent.high_x = outline.centre.x + outline.size;
        extent.high_y = outline.centre.y + outline.size;
        return extent;
      },
      [=] LICHTENBERG_HOST_DEVICE(int g, const Extent& extent) {
        if (absorb.grid.medium.extent)
          absorb.grid.medium.extent[g] = extent;
        else
          absorb(g, extent);
      });
  if (!grid.medium.extent) return;
  const SetsView sets = problem.sets;
  Extent *group_extent = grid.medium.extent, *set_extent = grid.medium.extent + problem.groups;
  run.sum_segments(
      problem.groups, [=] LICHTENBERG_HOST_DEVICE(int set) { return sets.start[set + 1] - sets.start[set]; },
      [=] LICHTENBERG_HOST_DEVICE(int set, int t) { return group_extent[sets.group[sets.start[set] + t]]; },
      [=] LICHTENBERG_HOST_DEVICE(int set, const Extent& extent) { set_extent[set] = extent; });
  run.for_each(problem.groups, [=] LICHTENBERG_HOST_DEVICE(int g) { absorb(g, set_extent[sets.first_group[g]]); });
}

/// Makes sort keys of all bodies, for bodies that the grid does not resolve by bin (the four cells around). Bins of
/// absorbed bodies are first, then bins of subgrid conductors, whose potential is an unknown or given. Resolved bodies
/// are last. Bodies of one group (with one potential) are contiguous in each bin.
template <class Executor>
void homogenized_keys(const Executor& run, ProblemView problem, GridView grid, SortArrays sort) {
  run.for_each(problem.bodies, [=] LICHTENBERG_HOST_DEVICE(int rank) {
    const int body = problem.body_at[rank];
    const int bins = bins_of(grid.layout), bin = bin_of(grid.layout, grid.bodies.outline[body].centre);
    sort.key[rank] = grid.bodies.resolved[body] ? 2 * bins : is_subgrid_body(problem, grid, body) ? bins + bin : bin;
    sort.index[rank] = body;
  });
}

/// Arrays for merging unresolved bodies, sorted by `key`, to points. One point represents the bodies with one potential
/// around the same four cells.
struct PointsView {
  const int* key;
  /// By body in the sorted order, with one more at the end: number of points that begin before it.
  int* before;
  /// By point, with one more at the end: its first body in the sorted order.
  int* first;
  /// By body in the sorted order: its shares in the four cells.
  HomogenizedPoint* share;
};

/// Merges bodies of one group around the same four cells (a bin) to one point, so that sums have one term for them. The
/// grid does not resolve the bodies. A group is a set of bodies with one potential.
template <class Executor>
void number_points(const Executor& run, ProblemView problem, GridView grid, PointsView points) {
  const int* item = grid.medium.absorbed_bodies.item;
  run.for_each(problem.bodies + 1, [=] LICHTENBERG_HOST_DEVICE(int k) {
    bool begins = k < problem.bodies && points.key[k] < 2 * bins_of(grid.layout);
    if (begins && k > 0)
      begins = points.key[k] != points.key[k - 1] || problem.group_of[item[k]] != problem.group_of[item[k - 1]];
    points.before[k] = begins;
  });
  run.exclusive_scan(points.before, problem.bodies + 1);
  run.for_each(problem.bodies, [=] LICHTENBERG_HOST_DEVICE(int k) {
    const int resolved = 2 * bins_of(grid.layout), point = points.before[k];
    const bool begins = points.before[k + 1] > point;
    grid.medium.point[item[k]] = begins ? point : -1;
    if (begins) points.first[point] = k;
    const bool is_last = points.key[k] < resolved && (k + 1 == problem.bodies || points.key[k + 1] == resolved);
    if (is_last) points.first[points.before[k + 1]] = k + 1;
  });
}

/// Returns the interpolation weight of the cell `slot`, mirrored cells included: signed, or the sum of absolute values
/// if not `sign`.
LICHTENBERG_HOST_DEVICE inline float weight_in(const Interpolation& around, int slot, bool sign) {
  float sum = 0;
  for (int k = 0; k < 4; ++k)
    if (around.cell[k] == slot) sum += sign ? around.weight[k] : std::abs(around.weight[k]);
  return sum;
}

/// Computes the shares of a point p (in cells) in the four cells around it: the interpolation weights times `times`,
/// signed if `sign`.
LICHTENBERG_HOST_DEVICE inline HomogenizedPoint homogenized_point(const ProblemView& problem, const Layout& at, Vec2 p,
                                                                  int group, bool sign, float times) {
  const Interpolation around = interpolate(at, p, problem.electrode);
  const auto [i, j] = base_of_bin(at, bin_of(at, p));
  HomogenizedPoint point{group, {}};
  for (int k = 0; k < 4; ++k)
    if (inside(at, i + k % 2, j + k / 2))
      point.share[k] = times * weight_in(around, slot_of(at, i + k % 2, j + k / 2), sign);
  return point;
}

/// Computes the shares of small bodies and groups in the four cells around each. The share of a body in the effective
/// medium is a part of its area. The share of a subgrid conductor (a body too small for the grid) is a part of its
/// conductance. For a group in the medium it is the interpolation weight. A group is a set of bodies with one
/// potential.
template <class Executor>
void distribute_points(const Executor& run, ProblemView problem, GridView grid, PointsView points) {
  const int* item = grid.medium.absorbed_bodies.item;
  run.for_each(problem.bodies, [=] LICHTENBERG_HOST_DEVICE(int k) {
    const int bins = bins_of(grid.layout), body = item[k];
    if (points.key[k] == 2 * bins) return;  // resolved
    const Outline& disk = grid.bodies.outline[body];
    const bool thin = points.key[k] >= bins;
    const double times = thin ? subgrid_conductance(disk, grid.layout) : std::numbers::pi * disk.size * disk.size;
    points.share[k] =
        homogenized_point(problem, grid.layout, disk.centre, problem.group_of[body], false, static_cast<float>(times));
  });
  run.sum_segments(
      problem.bodies,
      [=] LICHTENBERG_HOST_DEVICE(int p) {
        return p < points.before[problem.bodies] ? points.first[p + 1] - points.first[p] : 0;
      },
      [=] LICHTENBERG_HOST_DEVICE(int p, int t) { return points.share[points.first[p] + t]; },
      [=] LICHTENBERG_HOST_DEVICE(int p, const HomogenizedPoint& sum) {
        if (p >= points.before[problem.bodies]) return;
        grid.medium.absorbed_bodies.points[p] = sum;
        grid.medium.absorbed_bodies.points[p].group = problem.group_of[item[points.first[p]]];
      });
  run.for_each(problem.groups, [=] LICHTENBERG_HOST_DEVICE(int k) {
    if (k >= grid.medium.absorbed_groups.start[bins_of(grid.layout)]) return;  // not absorbed here
    const int g = grid.medium.absorbed_groups.item[k];
    grid.medium.absorbed_groups.points[k] = homogenized_point(problem, grid.layout, grid.medium.centre[g], g, true, 1);
  });
}

/// Homogenized points around one cell: those of the four bins that contain the cell. A homogenized point represents
/// unresolved bodies of one group between the same four cells (HomogenizedPoint).
struct CellBins {
  const Bins& bins;
  int below, above;  // first bin of either row

  LICHTENBERG_HOST_DEVICE CellBins(const Layout& at, const Bins& b, int i, int j)
      : bins(b), below(j * (at.nx + 1) + i), above(below + at.nx + 1) {}
  /// Returns the number of points in the two lower of the cell's four bins.
  LICHTENBERG_HOST_DEVICE int below_count() const { return bins.start[below + 2] - bins.start[below]; }
  /// Returns the number of homogenized points (HomogenizedPoint: small bodies of one group, treated as one point) in
  /// the four bins that contain the cell.
  LICHTENBERG_HOST_DEVICE int count() const { return below_count() + bins.start[above + 2] - bins.start[above]; }
  /// Returns value(group, share) of the t-th homogenized point. `share`: part of the point's area or conductance in the
  /// cell, or its interpolation weight. A group is a set of bodies with one potential.
  template <class Value>
  LICHTENBERG_HOST_DEVICE auto value(int t, Value of) const {
    const int n = below_count(), first = t < n ? below : above;
    const int k = bins.start[first] + (t < n ? t : t - n), corner = (k < bins.start[first + 1]) + 2 * (t < n);
    return of(bins.points[k].group, bins.points[k].share[corner]);
  }
};

/// Returns the sum of value(group, share) over the homogenized points (unresolved bodies of one group, between the same
/// four cells) around cell (i, j). `share`: part of the point's area or conductance in this cell, or its interpolation
/// weight. A group is a set of bodies with one potential.
template <class Value>
LICHTENBERG_HOST_DEVICE float gathered(const Layout& at, const Bins& bins, int i, int j, Value value) {
  const CellBins around(at, bins, i, j);
  float sum = 0;
  for (int t = 0; t < around.count(); ++t) sum += around.value(t, value);
  return sum;
}

/// Computes the effective permittivity of each cell (Maxwell Garnett) from the area of the absorbed disks in it.
template <class Executor>
void make_permittivity(const Executor& run, GridView grid) {
  run.sum_segments(
      static_cast<long>(grid.layout.nx) * grid.layout.ny,
      [=] LICHTENBERG_HOST_DEVICE(int cell) {
        return CellBins(grid.layout, grid.medium.absorbed_bodies, cell % grid.layout.nx, cell / grid.layout.nx).count();
      },
      [=] LICHTENBERG_HOST_DEVICE(int cell, int t) {
        return CellBins(grid.layout, grid.medium.absorbed_bodies, cell % grid.layout.nx, cell / grid.layout.nx)
            .value(t, [](int, float area) { return area; });
      },
      [=] LICHTENBERG_HOST_DEVICE(int cell, float fill) {
        grid.medium.permittivity[slot_of(grid.layout, cell % grid.layout.nx, cell / grid.layout.nx)] =
            effective_permittivity(fill);
      });
}

}  // namespace lichtenberg::laplace::device
