#pragma once

// Direct links of bodies to bodies and electrode sides: finds those of bodies without cells, computes and sorts all.

#include "solvers/laplace/cutcell/device/homogenized.hpp"

namespace lichtenberg::laplace::device {

/// Returns true if the body's potential is given or an unknown of this grid. Returns false if the body's group (bodies
/// with one potential) is part of the grid's effective medium (cells whose conductances include small bodies without
/// unknowns).
LICHTENBERG_HOST_DEVICE inline bool has_potential(const ProblemView& problem, const GridView& grid, int body) {
  return !grid.has_medium || !grid.medium.absorbed[problem.group_of[body]];
}

/// Calls f(other, kind, DirectLink::slot) for each direct link (a gap conductance) of the finest grid that this coarse
/// grid inherits, once for both bodies. At least one of the two bodies must be a subgrid conductor (a body too small
/// for the grid). Flux between conductors that nearly touch passes no cells, or only near-surface cells that the
/// V-cycle eliminates. The conductances do not depend on the cell size.
template <class F>
LICHTENBERG_HOST_DEVICE void for_each_inherited(const ProblemView& problem, const GridView& grid, int body, F f) {
  if (!has_potential(problem, grid, body)) return;
  const int rank = problem.rank_of[body];
  const auto inherit = [&](const DirectLink& link, int slot) {
    if (link.is_to_electrode() || link.other < body || !has_potential(problem, grid, link.other)) return;
    if (!grid.bodies.resolved[body] || !grid.bodies.resolved[link.other])
      f(link.other, DirectLink::Kind::inherited, slot);
  };
  for (int m = grid.inherited.link_start[rank]; m < grid.inherited.link_start[rank + 1]; ++m)
    inherit(grid.inherited.link[m], m);
  if (!grid.inherited.joined) return;
  for (int m = grid.inherited.joined_start[rank]; m < grid.inherited.joined_start[rank + 1]; ++m)
    inherit(grid.inherited.joined[m], -1 - m);
}

/// Calls f(owner, kind, corner) for each direct link (a gap conductance) of a body without cells to the owner of a cell
/// of another group. The owner's cell contains the body's centre, or is one of the four around a subgrid conductor.
/// `kind` and `corner` as in DirectLink. Also includes links inherited from the finest grid, with DirectLink::slot as
/// third argument. A group is a set of bodies with one potential.
template <class F>
LICHTENBERG_HOST_DEVICE void for_each_owner(const ProblemView& problem, const GridView& grid, int body, F f) {
  const int group = problem.group_of[body];
  if (const int owner = grid.bodies.cell_owner[body]; owner >= 0 && problem.group_of[owner] != group)
    f(owner, DirectLink::Kind::shared_cell, 0);
  if (grid.inherited.link) for_each_inherited(problem, grid, body, f);
  if (!grid.has_medium || !is_subgrid_body(problem, grid, body)) return;
  const Interpolation around = interpolate(grid.layout, grid.bodies.outline[body].centre, problem.electrode);
  for (int k = 0; k < 4; ++k) {
    const CellOwner owner = grid.cells.owner[around.cell[k]];
    if (around.weight[k] != 0 && !owner.is_fluid() && problem.group_of[owner.body()] != group)
      f(owner.body(), DirectLink::Kind::subgrid_conductor, k);
  }
}

/// Sets number[body] to the counts of a body. `direct_links`: number of the direct links (gap conductances) that
/// for_each_owner() finds for it. The other two counts are 1 for a subgrid conductor (a body too small for the grid)
/// and for a floating one, otherwise 0. `number` has bodies + 1 entries; the last one is 0.
template <class Executor>
void count_without_cells(const Executor& run, ProblemView problem, GridView grid, WithoutCells* number) {
  run.for_each(problem.bodies + 1, [=] LICHTENBERG_HOST_DEVICE(int body) {
    WithoutCells own;
    if (body < problem.bodies) {
      for_each_owner(problem, grid, body, [&](int, DirectLink::Kind, int) { ++own.direct_links; });
      own.subgrid_conductors = grid.has_medium && is_subgrid_body(problem, grid, body);
      own.floating_subgrid_conductors = own.subgrid_conductors > 0 && problem.floating[problem.group_of[body]];
    }
    number[body] = own;
  });
}

/// Lists the direct links (gap conductances) of bodies without cells, each for both bodies. The entries follow the
/// direct links of bodies with cells. `before` [bodies + 1]: numbers before each body.
template <class Executor>
void list_without_cells(const Executor& run, ProblemView problem, GridView grid, const WithoutCells* before) {
  run.for_each(problem.bodies, [=] LICHTENBERG_HOST_DEVICE(int body) {
    if (grid.number[Items::without_cells] == 0) return;
    int at = grid.number[Items::direct_links] - grid.number[Items::without_cells] + 2 * before[body].direct_links;
    for_each_owner(problem, grid, body, [&](int other, DirectLink::Kind kind, int which) {
      const auto k = static_cast<std::uint8_t>(which);  // corner
      grid.direct.link[at++] = {
          .own = body, .other = other, .slot = which, .kind = kind, .corner = k, .own_has_cell = false};
      grid.direct.link[at++] = {
          .own = other, .other = body, .slot = which, .kind = kind, .corner = k, .own_has_cell = true};
    });
  });
}

/// Minimum conductance of a direct link (a gap conductance) on the finest grid for clustering of groups (bodies with
/// one potential) on all grids. Two disks of radius 4 cells have it at a gap of 0.046 cells. Clusters (groups solved
/// together) need the host, which is not worth its time for weaker links.
constexpr double strong_link = 16;
/// Number of successive solves without a strong direct link (gap conductance) after which the host takes no part in the
/// set-up. It takes part again at the next strong link. Either change records all kernels again, which costs the time
/// of several solves.
constexpr int solves_to_forget_strong_links = 200;

/// Computes the conductances of all direct links (gap conductances) and, at least on the finest grid, their derivatives
/// with respect to the bodies' positions.
template <class Executor>
void make_direct_links(const Executor& run, ProblemView problem, GridView grid) {
  for_each_item(run, grid, Items::direct_links, [=] LICHTENBERG_HOST_DEVICE(int m) {
    DirectLink& link = grid.direct.link[m];
    const Outline& own = grid.bodies.outline[link.own];
    if (link.kind == DirectLink::Kind::inherited) {
      const DirectLink& of = link.slot >= 0 ? grid.inherited.link[link.slot] : grid.inherited.joined[-1 - link.slot];
      link.conductance = of.conductance;
      return;
    }
    if (link.kind != DirectLink::Kind::face) {
      const bool own_has_cell = link.own_has_cell;
      const Outline& other = grid.bodies.outline[link.other];
      if (link.kind == DirectLink::Kind::subgrid_conductor) {
        const Outline& disk = own_has_cell ? other : own;
        const Interpolation around = interpolate(grid.layout, disk.centre, problem.electrode);
        link.conductance = std::abs(around.weight[link.corner]) * subgrid_conductance(disk, grid.layout);
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
      const PairConductance c = conductor_link(own, p, e, 0.5, nullptr);
      link.conductance = c.value;
      link.gradient = c.gradient_a;
      return;
    }
    // Computes both directions in one order, so that the system is symmetric to the last bit.
    const Outline& other = grid.bodies.outline[link.other];
    const bool first = link.own < link.other;
    const PairConductance c =
        first ? conductor_link(own, p, e, 1.0, &other) : conductor_link(other, p + e, -e, 1.0, &own);
    link.conductance = c.value;
    link.gradient = first ? c.gradient_a : c.gradient_b;
    if (grid.finest && c.value > strong_link) grid.required[Items::strong_links] = 1;  // all write the same
  });
}

/// Makes sort keys of a list of direct links (gap conductances): the rank of each link's own body. The rank is the
/// body's place in the order by group (bodies with one potential). Unused entries come last.
template <class Executor>
void direct_link_keys(const Executor& run, ProblemView problem, GridView grid, Items::Kind kind, const DirectLink* link,
                      SortArrays sort) {
  run.for_each(grid.capacity[kind], [=] LICHTENBERG_HOST_DEVICE(int m) {
    sort.key[m] = m < grid.number[kind] ? problem.rank_of[link[m].own] : problem.bodies;
    sort.index[m] = m;
  });
}

/// Copies a list of direct links (gap conductances) to `sorted` in the order of `index`.
template <class Executor>
void sort_direct_links(const Executor& run, GridView grid, Items::Kind kind, const DirectLink* link, const int* index,
                       DirectLink* sorted) {
  for_each_item(run, grid, kind, [=] LICHTENBERG_HOST_DEVICE(int m) { sorted[m] = link[index[m]]; });
}

}  // namespace lichtenberg::laplace::device
