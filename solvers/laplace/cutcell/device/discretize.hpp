#pragma once

// From the bodies to one grid's covered cells, links and diagonals: level.cpp's rules, an item a body, a strip of
// cells, a link or a boundary cell.

#include "solvers/laplace/cutcell/device/grid.hpp"

namespace lichtenberg::laplace::device {

/// A row of a body's bounding box, or a part of it.
struct Strip {
  int body, j, from_i, to_i;
};

LICHTENBERG_HOST_DEVICE inline int strips_of(const CellRange& range) {
  return (range.to_j - range.from_j + 1) * ((range.to_i - range.from_i) / strip_width + 1);
}

/// A thin conductor (../medium.hpp): a disk that its grid does not resolve and that is no part of the medium either.
LICHTENBERG_HOST_DEVICE inline bool is_thin(const ProblemView& problem, const GridView& grid, int body) {
  return !grid.resolved[body] && !grid.absorbed[problem.group_of[body]];
}

LICHTENBERG_HOST_DEVICE inline Strip strip_at(const ProblemView& problem, const GridView& grid, int index) {
  const int rank = segment_of(grid.strip_start, problem.bodies, index);
  const int body = problem.body_at[rank];
  const CellRange range = cells_around(grid.outline[body], grid.layout.nx, grid.layout.ny);
  const int a_row = (range.to_i - range.from_i) / strip_width + 1;
  const int local = index - grid.strip_start[rank];
  const int from = range.from_i + local % a_row * strip_width;
  const int last = from + strip_width - 1;
  return {body, range.from_j + local / a_row, from, last < range.to_i ? last : range.to_i};
}

template <class Executor>
void outline_bodies(const Executor& run, ProblemView problem, GridView grid) {
  run.for_each(problem.bodies, [=] LICHTENBERG_HOST_DEVICE(int rank) {
    const int body = problem.body_at[rank];
    const Outline& shape = problem.shape[body];
    const Outline outline{shape.kind, shape.centre / grid.h, shape.end / grid.h, shape.size / grid.h};
    grid.outline[body] = outline;
    const int g = problem.group_of[body];
    const bool alone = problem.floating[g] && problem.first_rank[g + 1] - problem.first_rank[g] == 1;
    const bool resolved = !grid.medium || is_resolved(outline, alone);
    grid.resolved[body] = resolved;
    grid.present[body] = !resolved;  // it needs no cell
    grid.cell_owner[body] = -1;
  });
}

/// Strips of a body's cells. A thin conductor has a strip for its links.
template <class Executor>
void count_strips(const Executor& run, ProblemView problem, GridView grid) {
  run.for_each(problem.bodies + 1, [=] LICHTENBERG_HOST_DEVICE(int rank) {
    int strips = 0;
    if (rank < problem.bodies) {
      const int body = problem.body_at[rank];
      if (grid.resolved[body])
        strips = strips_of(cells_around(grid.outline[body], grid.layout.nx, grid.layout.ny));
      else
        strips = is_thin(problem, grid, body);
    }
    grid.strip_start[rank] = strips;
  });
}

/// Takes down how many strips there are; none, if there is no room for so many.
template <class Executor>
void settle_strips(const Executor& run, ProblemView problem, GridView grid) {
  run.template for_each<32>(1, [=] LICHTENBERG_HOST_DEVICE(int) {
    const int strips = grid.strip_start[problem.bodies];
    grid.wanted[Of::strips] = strips;
    grid.number[Of::strips] = strips <= grid.room[Of::strips] ? strips : 0;
    grid.number[Of::unknown_groups] = grid.wanted[Of::unknown_groups] = 0;  // make_group_diagonals
    grid.number[Of::newly_absorbed] = grid.wanted[Of::newly_absorbed] =
        grid.medium ? grid.absorbed_groups.start[bins_of(grid.layout)] : 0;
  });
}

/// Likewise all that is listed by strip or by body.
template <class Executor>
void settle_lists(const Executor& run, ProblemView problem, GridView grid, const WithoutCells* without_cells) {
  run.template for_each<32>(1, [=] LICHTENBERG_HOST_DEVICE(int) {
    const Counts total = grid.counts[grid.number[Of::strips]];
    const WithoutCells without = without_cells[problem.bodies];
    grid.wanted[Of::covered] = total.covered;
    grid.wanted[Of::links] = total.links;
    grid.wanted[Of::boundary] = total.boundary;
    grid.wanted[Of::direct_links] = total.direct_links + 2 * without.direct_links;
    grid.wanted[Of::without_cells] = 2 * without.direct_links;
    grid.wanted[Of::thin_conductors] = without.thin_conductors;
    grid.wanted[Of::floating_thin_conductors] = without.floating_thin_conductors;
    bool fits = true;
    for (int kind = Of::covered; kind <= Of::floating_thin_conductors; ++kind)
      fits = fits && grid.wanted[kind] <= grid.room[kind];
    if (!fits) grid.number[Of::strips] = 0;
    for (int kind = Of::covered; kind <= Of::floating_thin_conductors; ++kind)
      grid.number[kind] = fits ? grid.wanted[kind] : 0;
  });
}

/// Which body has which cell: the first one where they overlap; then, of the disks that have none, the first one in a
/// cell that is still free.
template <class Executor>
void cover_cells(const Executor& run, ProblemView problem, GridView grid) {
  for_each_of(run, grid, Of::strips, [=] LICHTENBERG_HOST_DEVICE(int index) {
    const Strip strip = strip_at(problem, grid, index);
    if (!grid.resolved[strip.body]) return;
    const Outline& outline = grid.outline[strip.body];
    for (int i = strip.from_i; i <= strip.to_i; ++i)
      if (covers(outline, i, strip.j)) claim(&grid.cover[slot_of(grid.layout, i, strip.j)], strip.body);
  });
  for_each_of(run, grid, Of::strips, [=] LICHTENBERG_HOST_DEVICE(int index) {
    const Strip strip = strip_at(problem, grid, index);
    for (int i = strip.from_i; i <= strip.to_i; ++i)
      if (grid.cover[slot_of(grid.layout, i, strip.j)].is(strip.body)) grid.present[strip.body] = 1;
  });
  const auto own_cell = [=] LICHTENBERG_HOST_DEVICE(int body) {
    const Outline& outline = grid.outline[body];
    if (outline.kind != Outline::Kind::disk || grid.present[body]) return static_cast<Cover*>(nullptr);
    const Layout& at = grid.layout;
    return &grid.cover[slot_of(at, cell_at(outline.centre.x, at.nx), cell_at(outline.centre.y, at.ny))];
  };
  run.for_each(problem.bodies, [=] LICHTENBERG_HOST_DEVICE(int body) {
    if (Cover* cover = own_cell(body)) claim(cover, problem.bodies + body);  // behind all bodies of the first round
  });
  run.for_each(problem.bodies, [=] LICHTENBERG_HOST_DEVICE(int body) {
    if (Cover* cover = own_cell(body)) {
      const int had = cover->body();  // read once: the winner may be writing it
      const int winner = had < problem.bodies ? had : had - problem.bodies;
      if (winner == body)
        *cover = Cover::by(body);
      else
        grid.cell_owner[body] = winner;
    }
  });
}

/// Calls the visitor for each covered cell, link, boundary cell and direct link of a strip, in order.
template <class Visitor>
LICHTENBERG_HOST_DEVICE void visit(const ProblemView& problem, const GridView& grid, const Strip& strip,
                                   Visitor& visitor) {
  const Layout& at = grid.layout;
  if (!grid.resolved[strip.body]) {
    const Interpolation around = interpolate(at, grid.outline[strip.body].centre, problem.electrode);
    for (int k = 0; k < 4; ++k)
      if (around.weight[k] != 0 && grid.cover[around.cell[k]].is_fluid())
        visitor.link(static_cast<int>(around.cell[k]), LinkEnd::of_thin_conductor(strip.body, k), false);
    return;
  }
  for (int i = strip.from_i; i <= strip.to_i; ++i) {
    const int slot = slot_of(at, i, strip.j);
    if (!grid.cover[slot].is(strip.body)) continue;
    visitor.covered(slot);
    for (int side = 0; side < 4; ++side) {
      const int ni = i + step_i(side), nj = strip.j + step_j(side);
      if (!inside(at, ni, nj)) {
        if (problem.electrode[side])
          visitor.direct_link(slot, side, DirectLink::electrode_face(side * problem.faces + (side < 2 ? strip.j : i)));
        continue;
      }
      const int next = slot_of(at, ni, nj);
      const Cover beside = grid.cover[next];
      if (!beside.is_fluid()) {
        const int other = beside.body();
        if (other != strip.body && problem.group_of[other] != problem.group_of[strip.body])
          visitor.direct_link(slot, side, other);
        continue;
      }
      // The cell's first link, by side, makes it a boundary cell.
      bool first = true;
      for (int s = 0; s < (side ^ 1); ++s) {
        const int bi = ni + step_i(s), bj = nj + step_j(s);
        first = first && !(inside(at, bi, bj) && !grid.cover[slot_of(at, bi, bj)].is_fluid());
      }
      visitor.link(next, LinkEnd::at_side(strip.body, side ^ 1), first);
    }
  }
}

struct CountVisitor {
  Counts counts;
  LICHTENBERG_HOST_DEVICE void covered(int) { ++counts.covered; }
  LICHTENBERG_HOST_DEVICE void direct_link(int, int, int) { ++counts.direct_links; }
  LICHTENBERG_HOST_DEVICE void link(int, LinkEnd, bool first) {
    ++counts.links;
    counts.boundary += first;
  }
};

struct FillVisitor {
  const GridView& grid;
  int body, group;
  Counts at;
  LICHTENBERG_HOST_DEVICE void covered(int slot) {
    grid.covered_slot[at.covered] = slot;
    grid.covered_group[at.covered++] = group;
  }
  LICHTENBERG_HOST_DEVICE void direct_link(int slot, int side, int other) {
    grid.direct_link[at.direct_links++] = {.own = body,
                                           .other = other,
                                           .slot = slot,
                                           .kind = DirectLink::Kind::face,
                                           .side = static_cast<std::uint8_t>(side)};
  }
  LICHTENBERG_HOST_DEVICE void link(int slot, LinkEnd end, bool first) {
    grid.link_slot[at.links] = slot;
    grid.link_group[at.links] = group;
    grid.link_end[at.links++] = end;
    if (!first) return;
    grid.cover[slot] = Cover::boundary_cell(at.boundary);
    grid.boundary_slot[at.boundary++] = slot;
  }
};

template <class Executor>
void count_in_strips(const Executor& run, ProblemView problem, GridView grid) {
  run.for_each(grid.room[Of::strips] + 1, [=] LICHTENBERG_HOST_DEVICE(int index) {
    CountVisitor visitor{};
    if (index < grid.number[Of::strips]) visit(problem, grid, strip_at(problem, grid, index), visitor);
    grid.counts[index] = visitor.counts;
  });
}

template <class Executor>
void fill_strips(const Executor& run, ProblemView problem, GridView grid) {
  for_each_of(run, grid, Of::strips, [=] LICHTENBERG_HOST_DEVICE(int index) {
    const Strip strip = strip_at(problem, grid, index);
    FillVisitor visitor{grid, strip.body, problem.group_of[strip.body], grid.counts[index]};
    visit(problem, grid, strip, visitor);
  });
}

/// The rectangle around a group's disks.
struct Extent {
  double low_x = infinite, low_y = infinite, high_x = -infinite, high_y = -infinite;
  double resolved = 0;  // how many are
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

/// Which groups have no potential of their own. `finer_absorbed`: on the next finer grid; null: none. `key`, `index`:
/// for sorting, the bins of the groups that this grid is the first to absorb.
template <class Executor>
void absorb_groups(const Executor& run, ProblemView problem, GridView grid, const int* finer_absorbed, int* key,
                   int* index) {
  run.sum_segments(
      problem.groups, [=] LICHTENBERG_HOST_DEVICE(int g) { return problem.first_rank[g + 1] - problem.first_rank[g]; },
      [=] LICHTENBERG_HOST_DEVICE(int g, int t) {
        const int body = problem.body_at[problem.first_rank[g] + t];
        const Outline& outline = grid.outline[body];
        Extent extent;
        extent.resolved = grid.resolved[body];
        extent.low_x = outline.centre.x - outline.size;
        extent.low_y = outline.centre.y - outline.size;
        extent.high_x = outline.centre.x + outline.size;
        extent.high_y = outline.centre.y + outline.size;
        return extent;
      },
      [=] LICHTENBERG_HOST_DEVICE(int g, Extent extent) {
        const double width = extent.high_x - extent.low_x, height = extent.high_y - extent.low_y;
        const bool absorbed =
            problem.floating[g] && extent.resolved == 0 && width <= least_extent && height <= least_extent;
        const bool newly = absorbed && !(finer_absorbed && finer_absorbed[g]);
        grid.absorbed[g] = absorbed;
        grid.centre[g] = {0.5 * (extent.low_x + extent.high_x), 0.5 * (extent.low_y + extent.high_y)};
        key[g] = newly ? bin_of(grid.layout, grid.centre[g]) : bins_of(grid.layout);
        index[g] = g;
      });
}

template <class Executor>
void smeared_keys(const Executor& run, ProblemView problem, GridView grid, int* key, int* index) {
  run.for_each(problem.bodies, [=] LICHTENBERG_HOST_DEVICE(int body) {
    const int bins = bins_of(grid.layout), bin = bin_of(grid.layout, grid.outline[body].centre);
    key[body] = grid.resolved[body] ? 2 * bins : is_thin(problem, grid, body) ? bins + bin : bin;
    index[body] = body;
  });
}

/// `start[k]`: the first of the n ascending keys that is not below k.
template <class Executor>
void start_segments(const Executor& run, const int* key, int n, int segments, int* start) {
  run.for_each(segments + 1, [=] LICHTENBERG_HOST_DEVICE(int segment) {
    int low = 0, high = n;
    while (low < high) {
      const int middle = (low + high) / 2;
      if (key[middle] < segment)
        low = middle + 1;
      else
        high = middle;
    }
    start[segment] = low;
  });
}

/// The items that may bring something to a cell: those of four bins.
struct CellBins {
  const Bins& bins;
  int below, above;  // first bin of either row

  LICHTENBERG_HOST_DEVICE CellBins(const Layout& at, const Bins& b, int i, int j)
      : bins(b), below(j * (at.nx + 1) + i), above(below + at.nx + 1) {}
  LICHTENBERG_HOST_DEVICE int below_count() const { return bins.start[below + 2] - bins.start[below]; }
  LICHTENBERG_HOST_DEVICE int count() const { return below_count() + bins.start[above + 2] - bins.start[above]; }
  LICHTENBERG_HOST_DEVICE int item(int t) const {
    const int n = below_count();
    return bins.item[t < n ? bins.start[below] + t : bins.start[above] + t - n];
  }
};

/// finish(slot, sum of value(item, slot) over the items in the bins around a cell). `lanes`: threads a cell.
template <int lanes, class Executor, class Value, class Finish>
void gather(const Executor& run, GridView grid, Bins bins, Value value, Finish finish) {
  run.template sum_segments<lanes>(
      static_cast<long>(grid.layout.nx) * grid.layout.ny,
      [=] LICHTENBERG_HOST_DEVICE(int cell) {
        return CellBins(grid.layout, bins, cell % grid.layout.nx, cell / grid.layout.nx).count();
      },
      [=] LICHTENBERG_HOST_DEVICE(int cell, int t) {
        const int i = cell % grid.layout.nx, j = cell / grid.layout.nx;
        return value(CellBins(grid.layout, bins, i, j).item(t), slot_of(grid.layout, i, j));
      },
      [=] LICHTENBERG_HOST_DEVICE(int cell, float sum) {
        finish(slot_of(grid.layout, cell % grid.layout.nx, cell / grid.layout.nx), sum);
      });
}

/// Share of a point in a cell: its interpolation weights, a mirrored one counted with or without its sign.
LICHTENBERG_HOST_DEVICE inline float weight_in(const Layout& at, Vec2 p, const bool* electrode, int slot, bool sign) {
  const Interpolation around = interpolate(at, p, electrode);
  float sum = 0;
  for (int k = 0; k < 4; ++k)
    if (around.cell[k] == slot) sum += sign ? around.weight[k] : std::abs(around.weight[k]);
  return sum;
}

/// Threads that share a sum of a few terms.
constexpr int few_lanes = 4;

/// finish(slot, sum of value(body, conductance) over the thin conductors around which a cell is).
template <class Executor, class Value, class Finish>
void sum_thin_conductors(const Executor& run, ProblemView problem, GridView grid, Value value, Finish finish) {
  gather<few_lanes>(
      run, grid, grid.thin_conductors,
      [=] LICHTENBERG_HOST_DEVICE(int body, int slot) {
        const Outline& disk = grid.outline[body];
        const float weight = weight_in(grid.layout, disk.centre, problem.electrode, slot, false);
        return value(body, weight * static_cast<float>(thin_conductance(disk.size)));
      },
      finish);
}

/// What the smeared-out disks make of the medium.
template <class Executor>
void make_permittivity(const Executor& run, ProblemView problem, GridView grid) {
  gather<32>(
      run, grid, grid.absorbed_bodies,
      [=] LICHTENBERG_HOST_DEVICE(int body, int slot) {
        const Outline& disk = grid.outline[body];
        const float area = static_cast<float>(std::numbers::pi * disk.size * disk.size);
        return area * weight_in(grid.layout, disk.centre, problem.electrode, slot, false);
      },
      [=] LICHTENBERG_HOST_DEVICE(int slot, float fill) { grid.permittivity[slot] = effective_permittivity(fill); });
}

/// Every link's conductance, on the finest grid with its derivatives.
template <class Executor>
void make_links(const Executor& run, ProblemView problem, GridView grid) {
  for_each_of(run, grid, Of::links, [=] LICHTENBERG_HOST_DEVICE(int m) {
    const int slot = grid.link_slot[m];
    const LinkEnd end = grid.link_end[m];
    if (end.is_thin_conductor()) {
      const Outline& disk = grid.outline[end.body()];
      const Interpolation around = interpolate(grid.layout, disk.centre, problem.electrode);
      grid.conductance[m] = std::abs(around.weight[end.corner()]) * thin_conductance(disk.size);
      return;
    }
    const int body = end.body(), side = end.side();
    const CellIndex cell = cell_of(grid.layout, slot);
    const Vec2 p = cell_centre(cell.i, cell.j), to_body = direction(side), onward = direction(side ^ 1);
    const Outline& outline = grid.outline[body];
    Conductance c = fluid_link(outline, p, to_body, grid.formula);
    int partner = -1;
    Vec2 partner_gradient;
    const int bi = cell.i + step_i(side ^ 1), bj = cell.j + step_j(side ^ 1);
    const Cover behind = inside(grid.layout, bi, bj) ? grid.cover[slot_of(grid.layout, bi, bj)] : Cover();
    if (!behind.is_fluid() && problem.group_of[behind.body()] != problem.group_of[body]) {
      const int other = behind.body();
      const Outline& beyond = grid.outline[other];
      Conductance back = fluid_link(beyond, p, onward, grid.formula);
      squeeze(outline, p + to_body, onward, beyond, c);
      const Squeeze squeezed = squeeze(beyond, p + onward, to_body, outline, back);
      if (squeezed.close) {
        partner = problem.group_of[other];
        partner_gradient = squeezed.partner_gradient;
      }
    }
    grid.conductance[m] = grid.medium ? c.value * grid.permittivity[slot] : c.value;
    const int k = grid.cover[slot].boundary_number();
    grid.boundary_link[side * grid.room[Of::boundary] + k] = m;
    if (!grid.finest) return;
    grid.gradient[m] = c.gradient;
    grid.partner_group[m] = partner;
    grid.partner_gradient[m] = partner_gradient;
  });
}

/// Conductances between the cells of a medium, each at the cell on the left or below.
template <class Executor>
void make_faces(const Executor& run, GridView grid) {
  run.for_each(grid.layout.ny, grid.layout.nx, [=] LICHTENBERG_HOST_DEVICE(int j, int i) {
    const Layout& at = grid.layout;
    const int slot = slot_of(at, i, j);
    const auto face = [&](int ni, int nj) {
      if (!inside(at, ni, nj) || !grid.cover[slot].is_fluid() || !grid.cover[slot_of(at, ni, nj)].is_fluid())
        return 0.0f;
      return face_conductance(grid.permittivity[slot], grid.permittivity[slot_of(at, ni, nj)]);
    };
    grid.east[slot] = face(i + 1, j);
    grid.north[slot] = face(i, j + 1);
  });
}

template <class Executor>
void make_medium_diagonals(const Executor& run, ProblemView problem, GridView grid) {
  make_faces(run, grid);
  // f is the sum over the thin conductors around a cell for now.
  run.fill(grid.f, 0, grid.layout.size() * sizeof(float));
  if (grid.may_have(Of::thin_conductors))
    sum_thin_conductors(
        run, problem, grid, [=] LICHTENBERG_HOST_DEVICE(int, float c) { return c; },
        [=] LICHTENBERG_HOST_DEVICE(int slot, float sum) { grid.f[slot] = sum; });
  run.for_each(grid.layout.ny, grid.layout.nx, [=] LICHTENBERG_HOST_DEVICE(int j, int i) {
    const Layout& at = grid.layout;
    const int slot = slot_of(at, i, j);
    double sum = 0;
    const Cover cover = grid.cover[slot];
    if (cover.is_fluid()) {
      const Neighbours n = neighbours(at, slot);
      sum = static_cast<double>(grid.east[n.west]) + grid.east[slot] + grid.north[n.south] + grid.north[slot] +
            grid.f[slot];
      for (int side = 0; side < 4; ++side) {
        if (!inside(at, i + step_i(side), j + step_j(side)) && problem.electrode[side])
          sum += 2 * grid.permittivity[slot];
        const int link = cover.is_boundary_cell() ? grid.boundary_link_of(cover.boundary_number(), side) : -1;
        if (link >= 0) sum += grid.conductance[link];
      }
    }
    grid.inverse_diagonal[slot] = sum > 0 ? static_cast<float>(1.0 / sum) : 0.0f;
  });
}

/// 1 / sum of conductances, for cells that have no link: 4 neighbours, at an electrode half a cell away conductance 2,
/// at an insulating side none; the boundary cells' own sums.
template <class Executor>
void make_diagonals(const Executor& run, ProblemView problem, GridView grid) {
  if (grid.medium) {
    make_medium_diagonals(run, problem, grid);
    return;
  }
  const int rows = 2 * (grid.layout.ny + 2), columns = static_cast<int>(grid.layout.stride);
  run.for_each(rows, columns, [=] LICHTENBERG_HOST_DEVICE(int row, int column) {
    const Layout& at = grid.layout;
    const int colour = row >= at.ny + 2;
    const int j = row - colour * (at.ny + 2) - 1, k = column - Layout::pad;
    const int slot = static_cast<int>(at.row(colour, j)) + k;
    float inverse = 0;
    const int i = 2 * k + Layout::parity(colour, j);
    if (k >= 0 && inside(at, i, j)) {
      if (grid.cover[slot].is_boundary_cell()) return;  // below
      int sum = 4;
      if (i == 0) sum += problem.electrode[0] ? 1 : -1;
      if (i == at.nx - 1) sum += problem.electrode[1] ? 1 : -1;
      if (j == 0) sum += problem.electrode[2] ? 1 : -1;
      if (j == at.ny - 1) sum += problem.electrode[3] ? 1 : -1;
      if (grid.cover[slot].is_fluid() && sum > 0) inverse = 1.0f / static_cast<float>(sum);
    }
    grid.inverse_diagonal[slot] = inverse;
  });
  for_each_of(run, grid, Of::boundary, [=] LICHTENBERG_HOST_DEVICE(int k) {
    const int slot = grid.boundary_slot[k];
    const CellIndex cell = cell_of(grid.layout, slot);
    double sum = 0;
    for (int side = 0; side < 4; ++side) {
      const int link = grid.boundary_link_of(k, side);
      if (link >= 0)
        sum += grid.conductance[link];
      else if (inside(grid.layout, cell.i + step_i(side), cell.j + step_j(side)))
        sum += 1;
      else if (problem.electrode[side])
        sum += 2;
    }
    grid.boundary_diagonal[k] = sum;
    grid.inverse_diagonal[slot] = static_cast<float>(1.0 / sum);
  });
}

/// Calls f(owner, kind, corner) for each body of another group that has a cell which one without cells is in or
/// exchanges flux with: kind and corner as in DirectLink.
template <class F>
LICHTENBERG_HOST_DEVICE void for_each_owner(const ProblemView& problem, const GridView& grid, int body, F f) {
  const int group = problem.group_of[body];
  if (const int owner = grid.cell_owner[body]; owner >= 0 && problem.group_of[owner] != group)
    f(owner, DirectLink::Kind::shared_cell, 0);
  if (!grid.medium || !is_thin(problem, grid, body)) return;
  const Interpolation around = interpolate(grid.layout, grid.outline[body].centre, problem.electrode);
  for (int k = 0; k < 4; ++k) {
    const Cover cover = grid.cover[around.cell[k]];
    if (around.weight[k] != 0 && !cover.is_fluid() && problem.group_of[cover.body()] != group)
      f(cover.body(), DirectLink::Kind::thin_conductor, k);
  }
}

template <class Executor>
void count_without_cells(const Executor& run, ProblemView problem, GridView grid, WithoutCells* number) {
  run.for_each(problem.bodies + 1, [=] LICHTENBERG_HOST_DEVICE(int body) {
    WithoutCells own;
    if (body < problem.bodies) {
      for_each_owner(problem, grid, body, [&](int, DirectLink::Kind, int) { ++own.direct_links; });
      own.thin_conductors = grid.medium && is_thin(problem, grid, body);
      own.floating_thin_conductors = own.thin_conductors > 0 && problem.floating[problem.group_of[body]];
    }
    number[body] = own;
  });
}

/// Lists the direct links of bodies without cells behind those of the strips; `before`: how many before each body.
template <class Executor>
void list_without_cells(const Executor& run, ProblemView problem, GridView grid, const WithoutCells* before) {
  run.for_each(problem.bodies, [=] LICHTENBERG_HOST_DEVICE(int body) {
    if (grid.number[Of::without_cells] == 0) return;
    int at = grid.number[Of::direct_links] - grid.number[Of::without_cells] + 2 * before[body].direct_links;
    for_each_owner(problem, grid, body, [&](int owner, DirectLink::Kind kind, int corner) {
      const auto k = static_cast<std::uint8_t>(corner);
      grid.direct_link[at++] = {.own = body, .other = owner, .kind = kind, .corner = k, .own_has_cell = false};
      grid.direct_link[at++] = {.own = owner, .other = body, .kind = kind, .corner = k, .own_has_cell = true};
    });
  });
}

template <class Executor>
void make_direct_links(const Executor& run, ProblemView problem, GridView grid) {
  for_each_of(run, grid, Of::direct_links, [=] LICHTENBERG_HOST_DEVICE(int m) {
    DirectLink& link = grid.direct_link[m];
    const Outline& own = grid.outline[link.own];
    if (link.kind != DirectLink::Kind::face) {
      const bool own_has_cell = link.own_has_cell;
      const Outline& other = grid.outline[link.other];
      if (link.kind == DirectLink::Kind::thin_conductor) {
        const Outline& disk = own_has_cell ? other : own;
        const Interpolation around = interpolate(grid.layout, disk.centre, problem.electrode);
        link.conductance = std::abs(around.weight[link.corner]) * thin_conductance(disk.size);
        return;
      }
      const PairConductance c = own_has_cell ? shared_cell_link(other, own) : shared_cell_link(own, other);
      link.conductance = c.value;
      link.gradient = own_has_cell ? c.gradient_b : c.gradient_a;
      return;
    }
    const CellIndex cell = cell_of(grid.layout, link.slot);
    const Vec2 p = cell_centre(cell.i, cell.j), e = direction(link.side);
    if (link.is_to_electrode()) {
      const PairConductance c = channel_between(own, p, e, 0.5, nullptr);
      link.conductance = c.value;
      link.gradient = c.gradient_a;
      return;
    }
    // In one order, so that either side gets the same bits: the system is symmetric.
    const Outline& other = grid.outline[link.other];
    const bool first = link.own < link.other;
    const PairConductance c =
        first ? channel_between(own, p, e, 1.0, &other) : channel_between(other, p + e, -e, 1.0, &own);
    link.conductance = c.value;
    link.gradient = first ? c.gradient_a : c.gradient_b;
  });
}

/// By the own body's rank, for sorting; behind them what there is room for.
template <class Executor>
void direct_link_keys(const Executor& run, ProblemView problem, GridView grid, int* key, int* index) {
  run.for_each(grid.room[Of::direct_links], [=] LICHTENBERG_HOST_DEVICE(int m) {
    key[m] = m < grid.number[Of::direct_links] ? problem.rank_of[grid.direct_link[m].own] : problem.bodies;
    index[m] = m;
  });
}

template <class Executor>
void sort_direct_links(const Executor& run, GridView grid, const int* index, DirectLink* sorted) {
  for_each_of(run, grid, Of::direct_links,
              [=] LICHTENBERG_HOST_DEVICE(int m) { sorted[m] = grid.direct_link[index[m]]; });
}

}  // namespace lichtenberg::laplace::device
