#pragma once

// Covered cells and lists of links of a grid, by the rules of level.cpp; one item per body or strip of cells.

#include "solvers/laplace/cutcell/device/grid.hpp"

namespace lichtenberg::laplace::device {

/// Up to strip_width cells of one row of a body's bounding box; unit of work of the device's kernels.
struct Strip {
  int body, j, from_i, to_i;
};

/// Returns the number of strips (parts of a row, at most strip_width cells) that cover a rectangle of cells.
LICHTENBERG_HOST_DEVICE inline int strips_of(const CellRange& range) {
  return (range.to_j - range.from_j + 1) * ((range.to_i - range.from_i) / strip_width + 1);
}

/// Returns true if a body is a subgrid conductor (../medium.hpp). It is a body that the grid does not resolve and that
/// is no part of the effective medium (cells whose conductances include small bodies without unknowns).
LICHTENBERG_HOST_DEVICE inline bool is_subgrid_body(const ProblemView& problem, const GridView& grid, int body) {
  return !grid.bodies.resolved[body] && !grid.medium.absorbed[problem.group_of[body]];
}

/// Returns the strip with the given index in the list of all bodies' strips. A strip is a part of a row of cells in a
/// body's bounding box.
LICHTENBERG_HOST_DEVICE inline Strip strip_at(const ProblemView& problem, const GridView& grid, int index) {
  const int rank = segment_of(grid.strips.start, problem.bodies, index);
  const int body = problem.body_at[rank];
  const CellRange range = cells_around(grid.bodies.outline[body], grid.layout.nx, grid.layout.ny);
  const int a_row = (range.to_i - range.from_i) / strip_width + 1;
  const int local = index - grid.strips.start[rank];
  const int from = range.from_i + local % a_row * strip_width;
  const int last = from + strip_width - 1;
  return {body, range.from_j + local / a_row, from, last < range.to_i ? last : range.to_i};
}

/// Computes the bodies' outlines in cells and whether the grid resolves them.
template <class Executor>
void outline_bodies(const Executor& run, ProblemView problem, GridView grid) {
  run.for_each(problem.bodies, [=] LICHTENBERG_HOST_DEVICE(int rank) {
    const int body = problem.body_at[rank];
    const Outline& shape = problem.shape[body];
    const Outline outline{shape.kind, shape.centre / grid.h,         shape.end / grid.h, shape.size / grid.h,
                          shape.link, {shape.data[0], shape.data[1]}};
    grid.bodies.outline[body] = outline;
    const int g = problem.group_of[body];
    const auto is_alone = [&] {  // of coarse grids only: the sets are found from the finest grid's links
      return problem.sets.is_alone ? problem.sets.is_alone[g] != 0 : problem.floating[g] && problem.members(g) == 1;
    };
    const bool resolved = !grid.has_medium || is_resolved(outline, is_alone());
    if (!resolved) grid.bodies.outline[body] = unresolved_disk(outline);
    grid.bodies.resolved[body] = resolved;
    grid.bodies.present[body] = !resolved;  // it needs no cell
    grid.bodies.cell_owner[body] = -1;
  });
}

/// Counts the strips (parts of rows of cells) of each body, by rank (order of bodies by group). A resolved body has
/// those in its bounding box, and a body that the medium absorbs has none. Subgrid conductors (bodies too small for the
/// grid) of one group around the same four cells have one strip, with the first body. A group is a set of bodies with
/// one potential.
template <class Executor>
void count_strips(const Executor& run, ProblemView problem, GridView grid) {
  run.for_each(problem.bodies + 1, [=] LICHTENBERG_HOST_DEVICE(int rank) {
    int strips = 0;
    if (rank < problem.bodies) {
      const int body = problem.body_at[rank];
      if (grid.bodies.resolved[body])
        strips = strips_of(cells_around(grid.bodies.outline[body], grid.layout.nx, grid.layout.ny));
      else
        strips = is_subgrid_body(problem, grid, body) && grid.medium.point[body] >= 0;
    }
    grid.strips.start[rank] = strips;
  });
}

/// Sets the number of strips (parts of rows in the bodies' bounding boxes), or 0 if it exceeds the capacity. Resets the
/// numbers of items that later kernels set.
template <class Executor>
void finalize_strip_count(const Executor& run, ProblemView problem, GridView grid) {
  run.template for_each<32>(1, [=] LICHTENBERG_HOST_DEVICE(int) {
    const int strips = grid.strips.start[problem.bodies];
    grid.required[Items::strips] = strips;
    grid.number[Items::strips] = strips <= grid.capacity[Items::strips] ? strips : 0;
    for (const Items::Kind kind :
         {Items::unknown_groups, Items::own_groups, Items::strong_links})  // of those that set them
      grid.number[kind] = grid.required[kind] = 0;
    grid.number[Items::newly_absorbed] = grid.required[Items::newly_absorbed] =
        grid.has_medium ? grid.medium.absorbed_groups.start[bins_of(grid.layout)] : 0;
  });
}

/// Sets the numbers of all items that are listed by strip (part of a row of cells) or by body: links, covered cells and
/// others. All become 0 if one exceeds its capacity.
template <class Executor>
void finalize_list_counts(const Executor& run, ProblemView problem, GridView grid, const WithoutCells* without_cells) {
  run.template for_each<32>(1, [=] LICHTENBERG_HOST_DEVICE(int) {
    const Counts total = grid.strips.counts[grid.number[Items::strips]];
    const WithoutCells without = without_cells[problem.bodies];
    grid.required[Items::covered] = total.covered;
    grid.required[Items::links] = total.links;
    grid.required[Items::boundary] = total.boundary;
    grid.required[Items::direct_links] = total.direct_links + 2 * without.direct_links;
    grid.required[Items::without_cells] = 2 * without.direct_links;
    grid.required[Items::subgrid_conductors] = without.subgrid_conductors;
    grid.required[Items::floating_subgrid_conductors] = without.floating_subgrid_conductors;
    bool fits = true;
    for (int kind = Items::covered; kind <= Items::floating_subgrid_conductors; ++kind)
      fits = fits && grid.required[kind] <= grid.capacity[kind];
    if (!fits) grid.number[Items::strips] = 0;
    for (int kind = Items::covered; kind <= Items::floating_subgrid_conductors; ++kind)
      grid.number[kind] = fits ? grid.required[kind] : 0;
  });
}

/// Assigns cells to the bodies that cover their centres; where bodies overlap, to the first. Then a resolved disk
/// without a cell gets the cell that contains its centre, if that cell is fluid. If several such disks have their
/// centres in it, the first gets it.
template <class Executor>
void cover_cells(const Executor& run, ProblemView problem, GridView grid) {
  for_each_item(run, grid, Items::strips, [=] LICHTENBERG_HOST_DEVICE(int index) {
    const Strip strip = strip_at(problem, grid, index);
    if (!grid.bodies.resolved[strip.body]) return;
    const Outline& outline = grid.bodies.outline[strip.body];
    for (int i = strip.from_i; i <= strip.to_i; ++i)
      if (covers(outline, i, strip.j)) claim(&grid.cells.owner[slot_of(grid.layout, i, strip.j)], strip.body);
  });
  for_each_item(run, grid, Items::strips, [=] LICHTENBERG_HOST_DEVICE(int index) {
    const Strip strip = strip_at(problem, grid, index);
    for (int i = strip.from_i; i <= strip.to_i; ++i)
      if (grid.cells.owner[slot_of(grid.layout, i, strip.j)].is(strip.body)) grid.bodies.present[strip.body] = 1;
  });
  const auto own_cell = [=] LICHTENBERG_HOST_DEVICE(int body) {
    const Outline& outline = grid.bodies.outline[body];
    if (outline.kind != Outline::Kind::disk || grid.bodies.present[body]) return static_cast<CellOwner*>(nullptr);
    const Layout& at = grid.layout;
    return &grid.cells.owner[slot_of(at, cell_at(outline.centre.x, at.nx), cell_at(outline.centre.y, at.ny))];
  };
  run.for_each(problem.bodies, [=] LICHTENBERG_HOST_DEVICE(int body) {
    if (CellOwner* owner = own_cell(body)) claim(owner, problem.bodies + body);  // behind all bodies of the first round
  });
  run.for_each(problem.bodies, [=] LICHTENBERG_HOST_DEVICE(int body) {
    if (CellOwner* owner = own_cell(body)) {
      const int had = owner->body();  // read once: the winner may be writing it
      const int winner = had < problem.bodies ? had : had - problem.bodies;
      if (winner == body)
        *owner = CellOwner::by(body);
      else
        grid.bodies.cell_owner[body] = winner;
    }
  });
}

/// Calls the visitor's functions for the items of a strip (part of a row of cells of a body), in a fixed order. Items
/// are covered cells, links to fluid cells (conductances), and direct links (gap conductances) to other conductors and
/// electrode sides.
template <class Visitor>
LICHTENBERG_HOST_DEVICE void visit(const ProblemView& problem, const GridView& grid, const Strip& strip,
                                   Visitor& visitor) {
  const Layout& at = grid.layout;
  if (!grid.bodies.resolved[strip.body]) {
    const float* share = grid.medium.absorbed_bodies.points[grid.medium.point[strip.body]].share;
    const auto [i, j] = base_of_bin(at, bin_of(at, grid.bodies.outline[strip.body].centre));
    for (int k = 0; k < 4; ++k) {
      if (share[k] == 0) continue;  // as beyond the box
      const int slot = slot_of(at, i + k % 2, j + k / 2);
      if (grid.cells.owner[slot].is_fluid()) visitor.link(slot, LinkEnd::at_subgrid_conductor(strip.body, k), false);
    }
    return;
  }
  for (int i = strip.from_i; i <= strip.to_i; ++i) {
    const int slot = slot_of(at, i, strip.j);
    if (!grid.cells.owner[slot].is(strip.body)) continue;
    visitor.covered(slot);
    for (int side = 0; side < 4; ++side) {
      const int ni = i + step_i(side), nj = strip.j + step_j(side);
      if (!inside(at, ni, nj)) {
        if (problem.electrode[side])
          visitor.direct_link(slot, side, DirectLink::electrode_face(side * problem.faces + (side < 2 ? strip.j : i)));
        continue;
      }
      const int next = slot_of(at, ni, nj);
      const CellOwner beside = grid.cells.owner[next];
      if (!beside.is_fluid()) {
        const int other = beside.body();
        if (other != strip.body && problem.group_of[other] != problem.group_of[strip.body])
          visitor.direct_link(slot, side, other);
        continue;
      }
      // A cell's first link, by side, makes it a boundary cell.
      bool first = true;
      for (int s = 0; s < (side ^ 1); ++s) {
        const int bi = ni + step_i(s), bj = nj + step_j(s);
        first = first && !(inside(at, bi, bj) && !grid.cells.owner[slot_of(at, bi, bj)].is_fluid());
      }
      visitor.link(next, LinkEnd::at_side(strip.body, side ^ 1), first);
    }
  }
}

/// Visitor that counts the items of a strip (part of a row of cells): covered cells, links, boundary cells, direct
/// links.
struct CountVisitor {
  Counts counts;
  LICHTENBERG_HOST_DEVICE void covered(int) { ++counts.covered; }
  LICHTENBERG_HOST_DEVICE void direct_link(int, int, int) { ++counts.direct_links; }
  LICHTENBERG_HOST_DEVICE void link(int, LinkEnd, bool first) {
    ++counts.links;
    counts.boundary += first;
  }
};

/// Visitor that writes the items of a strip (part of a row of cells) to the grid's lists, starting at the indices `at`.
/// Items are covered cells, links, boundary cells and direct links.
struct FillVisitor {
  const GridView& grid;
  int body, group;
  Counts at;
  LICHTENBERG_HOST_DEVICE void covered(int slot) {
    grid.covered.slot[at.covered] = slot;
    grid.covered.group[at.covered++] = group;
  }
  LICHTENBERG_HOST_DEVICE void direct_link(int slot, int side, int other) {
    grid.direct.link[at.direct_links++] = {.own = body,
                                           .other = other,
                                           .slot = slot,
                                           .kind = DirectLink::Kind::face,
                                           .side = static_cast<std::uint8_t>(side)};
  }
  LICHTENBERG_HOST_DEVICE void link(int slot, LinkEnd end, bool first) {
    grid.links.slot[at.links] = slot;
    grid.links.group[at.links] = group;
    grid.links.end[at.links++] = end;
    if (!first) return;
    grid.cells.owner[slot] = CellOwner::boundary_cell(at.boundary);
    grid.boundary.slot[at.boundary] = slot;
    for (int side = 0; side < 4; ++side) {
      grid.boundary.link[side * grid.capacity[Items::boundary] + at.boundary] = -1;
      grid.boundary.coupling[4 * at.boundary + side] = {};
    }
    ++at.boundary;
  }
};

/// Counts the items of each strip (part of a row): covered cells, links, boundary cells and direct links. A boundary
/// cell is a fluid cell next to a conductor, a direct link a gap conductance.
template <class Executor>
void count_in_strips(const Executor& run, ProblemView problem, GridView grid) {
  run.for_each(grid.capacity[Items::strips] + 1, [=] LICHTENBERG_HOST_DEVICE(int index) {
    CountVisitor visitor{};
    if (index < grid.number[Items::strips]) visit(problem, grid, strip_at(problem, grid, index), visitor);
    grid.strips.counts[index] = visitor.counts;
  });
}

/// Writes the covered cells, links, boundary cells (fluid cells next to a conductor) and direct links (gap
/// conductances) of all strips to the grid's lists. A strip is a part of a row.
template <class Executor>
void fill_strips(const Executor& run, ProblemView problem, GridView grid) {
  for_each_item(run, grid, Items::strips, [=] LICHTENBERG_HOST_DEVICE(int index) {
    const Strip strip = strip_at(problem, grid, index);
    FillVisitor visitor{grid, strip.body, problem.group_of[strip.body], grid.strips.counts[index]};
    visit(problem, grid, strip, visitor);
  });
}

/// Finds the segments of n keys in ascending order: start[k] becomes the index of the first key that is at least k, for
/// k = 0 ... segments. If `position` is not null, start[k] becomes its entry at that index.
template <class Executor>
void start_segments(const Executor& run, const int* key, int n, int segments, int* start,
                    const int* position = nullptr) {
  run.for_each(segments + 1, [=] LICHTENBERG_HOST_DEVICE(int segment) {
    int low = 0, high = n;
    while (low < high) {
      const int middle = (low + high) / 2;
      if (key[middle] < segment)
        low = middle + 1;
      else
        high = middle;
    }
    start[segment] = position ? position[low] : low;
  });
}

}  // namespace lichtenberg::laplace::device
