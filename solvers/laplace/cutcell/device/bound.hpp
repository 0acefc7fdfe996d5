#pragma once

// Eliminated near-surface cells (../eliminated_cells.hpp) on grids that have their own kernels in the V-cycle. The
// functions find these cells, compute the Schur complement that their elimination leaves in groups' equations, and
// eliminate them in the cycle (../kron_reduction.hpp). In the second half of the V-cycle, tiles store in such a cell
// the flux from its neighbours divided by its diagonal. The value stays until groups have been relaxed. A group's sum
// over all its links then equals the result of the elimination.

#include "solvers/laplace/cutcell/device/direct_links.hpp"
#include "solvers/laplace/cutcell/device/divided.hpp"
#include "solvers/laplace/cutcell/device/pieces.hpp"
#include "solvers/laplace/cutcell/eliminated_cells.hpp"

namespace lichtenberg::laplace::device {

/// Links of a boundary cell (a fluid cell next to a conductor), by side. Also holds whether they are large enough for
/// an elimination of the cell in the V-cycle. A link is the conductance to the body behind a side.
struct LinksOfCell {
  /// Index of the link on each side in LinkArrays; -1: none.
  int link[4];
  /// Floating group behind each side; -1: no link, or a group of given potential.
  int group[4];
  /// Conductance to each group, the sum over the sides with this group, stored at the first of them; else 0.
  double conductance[4];
  /// Sum of the conductances of all the cell's faces and links.
  double diagonal;
  bool is_eliminated = false;
  /// Number of pairs of groups that the elimination of the cell links.
  int joined = 0;

  /// Collects the links (conductances to conductors) of the boundary cell number k, a fluid cell next to a conductor.
  LICHTENBERG_HOST_DEVICE LinksOfCell(const ProblemView& problem, const GridView& grid, int k)
      : diagonal(grid.boundary.diagonal[k]) {
    bool is_close = false, floats = false;
    int groups = 0;
    for (int side = 0; side < 4; ++side) {
      link[side] = grid.boundary_link_of(k, side);
      group[side] = -1;
      conductance[side] = 0;
      if (link[side] < 0) continue;
      const double c = grid.links.conductance[link[side]];
      is_close = is_close || c >= EliminatedCells::least_conductance;
      const int g = grid.links.group[link[side]];
      if (!problem.floating[g]) continue;
      floats = true;
      group[side] = g;
      const int first = first_of(side);
      conductance[first] += c;
      groups += first == side;
    }
    is_eliminated = is_close && floats;
    joined = is_eliminated ? groups * (groups - 1) / 2 : 0;
  }
  /// Returns the first side whose link leads to the same group (bodies with one potential) as that of `side`.
  LICHTENBERG_HOST_DEVICE int first_of(int side) const {
    int first = 0;
    while (group[first] != group[side]) ++first;
    return first;
  }
};

/// Returns true if subgrid conductors (bodies too small for the grid) exchange flux with the cell at the memory index
/// `slot`. LinksOfCell does not contain their links.
LICHTENBERG_HOST_DEVICE inline bool has_subgrid_conductors(const GridView& grid, int slot) {
  if (!grid.has_medium || !grid.may_have(Items::subgrid_conductors)) return false;
  const CellIndex cell = cell_of(grid.layout, slot);
  return gathered(grid.layout, grid.medium.subgrid_conductors, cell.i, cell.j, [](int, float c) { return c; }) > 0;
}

/// Finds the near-surface cells that the V-cycle eliminates, with the Schur-complement terms at their links. Such a
/// cell has a large conductance to a conductor, a link to a floating group, and no flux to subgrid conductors (bodies
/// too small for the grid). `joined_before` [boundary cells + 1]: becomes, for each cell, the number of list entries of
/// all cells before it. An entry is one end of a conductance that the elimination of a cell adds between two groups
/// (list_joined()). A boundary cell is a fluid cell next to a conductor; a group is a set of bodies with one potential.
template <class Executor>
void find_bound_cells(const Executor& run, ProblemView problem, GridView grid, int* joined_before) {
  run.fill(grid.bound.share, 0, grid.capacity[Items::links] * sizeof(float));
  run.for_each(grid.capacity[Items::boundary] + 1, [=] LICHTENBERG_HOST_DEVICE(int k) {
    joined_before[k] = 0;
    if (k >= grid.number[Items::boundary]) return;
    const LinksOfCell of(problem, grid, k);
    const bool is_eliminated = of.is_eliminated && !has_subgrid_conductors(grid, grid.boundary.slot[k]);
    grid.bound.is_eliminated[k] = is_eliminated;
    if (!is_eliminated) return;
    joined_before[k] = 2 * of.joined;
    for (int side = 0; side < 4; ++side) {
      if (of.group[side] < 0) continue;
      const double c = grid.links.conductance[of.link[side]], all = of.conductance[of.first_of(side)];
      grid.bound.share[of.link[side]] = static_cast<float>(c / of.diagonal);
      grid.bound.kept[of.link[side]] = c / all * EliminatedCells::schur_diagonal(all, of.diagonal);
      for (int other = 0; other < side; ++other)
        if (grid.finest &&
            EliminatedCells::schur_offdiagonal(of.conductance[side], of.conductance[other], of.diagonal) > strong_link)
          grid.required[Items::strong_links] = 1;  // all write the same
    }
  });
  run.exclusive_scan(joined_before, grid.capacity[Items::boundary] + 1);
  run.template for_each<32>(1, [=] LICHTENBERG_HOST_DEVICE(int) {
    const int links = joined_before[grid.capacity[Items::boundary]];
    grid.required[Items::joined_links] = links;
    grid.number[Items::joined_links] = links <= grid.capacity[Items::joined_links] ? links : 0;
  });
}

/// Lists the conductances that the elimination of near-surface cells adds between groups (Schur complement). Such a
/// cell has a large conductance to a conductor; a group is a set of bodies with one potential. Each pair of groups of a
/// cell gives two entries of `list`, one for a body of each group. `joined_before`: from find_bound_cells().
template <class Executor>
void list_joined(const Executor& run, ProblemView problem, GridView grid, const int* joined_before, DirectLink* list) {
  for_each_item(run, grid, Items::boundary, [=] LICHTENBERG_HOST_DEVICE(int k) {
    if (grid.number[Items::joined_links] == 0 || joined_before[k + 1] == joined_before[k]) return;
    int at = joined_before[k];
    const LinksOfCell of(problem, grid, k);
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < a; ++b) {
        if (of.conductance[a] == 0 || of.conductance[b] == 0) continue;
        const double c = EliminatedCells::schur_offdiagonal(of.conductance[a], of.conductance[b], of.diagonal);
        const int body_a = grid.links.end[of.link[a]].body(), body_b = grid.links.end[of.link[b]].body();
        list[at++] = {.own = body_a, .other = body_b, .kind = DirectLink::Kind::eliminated_cell, .conductance = c};
        list[at++] = {.own = body_b, .other = body_a, .kind = DirectLink::Kind::eliminated_cell, .conductance = c};
      }
  });
}

/// Computes the diagonals of the groups' equations in the V-cycle, and their inverses. A diagonal is a sum of
/// conductances without couplings, after elimination of near-surface cells (Schur complement). A group is a set of
/// bodies with one potential.
template <class Executor>
void make_cycle_diagonals(const Executor& run, ProblemView problem, GridView grid) {
  run.sum_pieces(
      grid.link_pieces(problem), grid.pieces.partial,
      [=] LICHTENBERG_HOST_DEVICE(int link) {
        return grid.bound.share[link] > 0 ? grid.bound.kept[link] : grid.links.conductance[link];
      },
      DirectConductances{problem, grid},
      [=] LICHTENBERG_HOST_DEVICE(int g, double sum) {
        if (!(grid.groups.diagonal[g] > 0)) sum = 0;
        grid.groups.cycle_diagonal[g] = sum;
        grid.groups.inverse_diagonal[g] = sum > 0 ? static_cast<float>(1.0 / sum) : 0.0f;
      });
}

/// Computes the flux to each group (bodies with one potential) from the right-hand sides of eliminated near-surface
/// cells, before the first relaxation of the groups. Stores the flux in `cycle.flux`, plus the charge if there are no
/// clusters. Also sets the groups' first potentials `cycle.phi`, (charge + flux) / diagonal. With clusters (groups
/// solved together), sets the groups' right-hand sides `cycle.group_rhs` (charge + flux) in double precision. An
/// eliminated cell is a fluid cell with a large conductance to a conductor.
template <class Executor>
void sum_bound_cells(const Executor& run, ProblemView problem, GridView grid) {
  sum_by_group(
      run, grid, links_by_group(problem, grid, grid.cycle.partial),
      [=] LICHTENBERG_HOST_DEVICE(int link) {
        const float share = grid.bound.share[link];
        return share > 0 ? share * grid.cycle.f[grid.links.slot[link]] : 0.0f;
      },
      parallel::NoAddedValues{},
      [=] LICHTENBERG_HOST_DEVICE(int g, float sum) {
        const float all = grid.cycle.charge[g] + sum;
        grid.cycle.flux[g] = grid.groups.clusters ? sum : all;
        grid.cycle.phi[g] = all * grid.groups.inverse_diagonal[g];
        if (grid.groups.clusters) grid.cycle.group_rhs[g] = static_cast<double>(grid.cycle.charge[g]) + sum;
      });
}

/// Completes the potentials v of eliminated near-surface cells by the flux from groups (back substitution). On entry v
/// contains the part due to neighbouring cells. An eliminated cell is a fluid cell with a large conductance to a
/// conductor. A group is a set of bodies with one potential.
template <class Executor>
void update_bound_cells(const Executor& run, GridView grid) {
  for_each_item(run, grid, Items::boundary, [=] LICHTENBERG_HOST_DEVICE(int k) {
    if (!grid.bound.is_eliminated[k]) return;
    const int slot = grid.boundary.slot[k];
    float flux = 0;
    for (int m = 4 * k; m < 4 * k + 4; ++m)
      flux += grid.boundary.coupling[m].conductance * grid.cycle.phi[grid.boundary.coupling[m].group];
    grid.cycle.v[slot] += flux * grid.cells.inverse_diagonal[slot];
  });
}

}  // namespace lichtenberg::laplace::device
