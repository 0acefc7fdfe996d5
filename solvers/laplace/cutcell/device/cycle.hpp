#pragma once

// Large grids of the V-cycle, with a kernel per step: the halves of tiles.hpp, and the steps of groups before and after
// them.

#include "solvers/laplace/cutcell/device/bound.hpp"
#include "solvers/laplace/cutcell/device/relax_clusters.hpp"
#include "solvers/laplace/cutcell/device/tiles.hpp"

namespace lichtenberg::laplace::device {

/// Completes the preconditioned residual z if the V-cycle has one grid only: 0 in covered cells (inside conductors),
/// and the potentials phi of the groups (bodies with one potential).
template <class Executor>
void complete_potentials(const Executor& run, ProblemView problem, GridView grid, PreconditionedResidual z) {
  const int cells = static_cast<int>(grid.layout.size());
  run.for_each(cells, [=] LICHTENBERG_HOST_DEVICE(int k) {
    if (!(grid.cells.inverse_diagonal[k] > 0)) z.cell[k] = 0;
  });
  run.for_each(problem.groups, [=] LICHTENBERG_HOST_DEVICE(int g) { z.group[g] = grid.cycle.phi[g]; });
}

/// Function that stores an entry of the residual as right-hand side of the V-cycle on the finest grid. Entries by slot
/// (memory index) become f, the groups' entries become `charge`. It also relaxes the group (bodies with one potential):
/// phi = charge / diagonal.
struct StoreResidual {
  GridView grid;
  LICHTENBERG_HOST_DEVICE void operator()(int k, double r) const {
    const int cells = static_cast<int>(grid.layout.size());
    if (k < cells) {
      grid.cycle.f[k] = static_cast<float>(r);
    } else {
      grid.cycle.charge[k - cells] = static_cast<float>(r);
      grid.cycle.phi[k - cells] = grid.cycle.charge[k - cells] * grid.groups.inverse_diagonal[k - cells];
    }
  }
};

/// Stores the residual r as right-hand side of the V-cycle on the finest grid (StoreResidual).
template <class Executor>
void store_residual(const Executor& run, ProblemView problem, GridView grid, const double* r) {
  const StoreResidual take{grid};
  for_each_entry(run, grid, problem.groups, [=] LICHTENBERG_HOST_DEVICE(int k) { take(k, r[k]); });
}

/// Flux to a group through its direct links (gap conductances) with other groups, as additional terms of a sum over its
/// links to cells. Groups of given potential have 0 in `phi`: they are on the right-hand side. A group is a set of
/// bodies with one potential.
template <class Real>
struct DirectFluxes {
  ProblemView problem;
  GridView grid;
  const Real* phi;
  LICHTENBERG_HOST_DEVICE int count(int g) const {
    return grid.may_have(Items::direct_links) ? grid.direct_links_of(problem, g) : 0;
  }
  LICHTENBERG_HOST_DEVICE Real value(int g, int t) const {
    const DirectLink& link = grid.direct.link[grid.first_direct_link(problem, g) + t];
    return link.is_to_electrode() ? Real(0) : static_cast<Real>(link.conductance) * phi[problem.group_of[link.other]];
  }
};

/// Relaxes the groups' potentials by one Jacobi sweep: (flux + flux from other groups) / diagonal. Clusters (strongly
/// linked groups) are relaxed together instead. A group is a set of bodies with one potential.
template <class Executor>
void relax_direct_links(const Executor& run, ProblemView problem, GridView grid, GroupSweep sweep) {
  if (grid.groups.clusters) return relax_clusters(run, problem, grid, sweep);
  const CycleFluxes phi_fluxes{problem, grid, sweep.phi};
  run.template sum_segments<group_lanes>(
      problem.groups, [=] LICHTENBERG_HOST_DEVICE(int g) { return phi_fluxes.count(g); },
      [=] LICHTENBERG_HOST_DEVICE(int g, int t) {
        const float own = phi_fluxes.value(g, t);
        return sweep.correction ? own + CycleFluxes{phi_fluxes.problem, phi_fluxes.grid, sweep.correction}.value(g, t)
                                : own;
      },
      [=] LICHTENBERG_HOST_DEVICE(int g, float sum) {
        sweep.next[g] = (sweep.flux[g] + sum) * grid.groups.inverse_diagonal[g];
        if (sweep.z) sweep.z[g] = sweep.next[g];
      });
}

/// Computes the groups' residuals after the first half of the V-cycle, as `charge` of the coarse grid. A group is a set
/// of bodies with one potential. The function restrict_charges() adds the residuals of the cells that a group covers. A
/// cluster (groups solved together) had a zero residual when it was relaxed, so that its residual consists of later
/// changes only.
template <class Executor>
void restrict_group_residuals(const Executor& run, ProblemView problem, GridView fine, GridView coarse,
                              const float* phi) {
  const auto flux = [=] LICHTENBERG_HOST_DEVICE(int link) {
    return static_cast<float>(fine.links.conductance[link]) * fine.cycle.v[fine.links.slot[link]];
  };
  const float* before = fine.groups.clusters ? fine.cycle.phi : nullptr;
  sum_by_group(run, fine, links_by_group(problem, fine, fine.cycle.partial), flux,
               CycleFluxes{problem, fine, phi, nullptr, before}, [=] LICHTENBERG_HOST_DEVICE(int g, float sum) {
                 const float inverse = fine.groups.inverse_diagonal[g];
                 float residual = sum + (fine.cycle.charge[g] - phi[g] / inverse);
                 if (before && fine.groups.clusters->row[g] >= 0)
                   residual = fine.binds ? sum - fine.cycle.flux[g] : sum;
                 coarse.cycle.charge[g] = inverse > 0 ? residual : 0.0f;
               });
}

/// Distributes the residuals of groups (bodies with one potential) to the right-hand side of the four cells around
/// each. It does so for groups that are unknowns of the next finer grid and part of this grid's effective medium (cells
/// whose conductances include small bodies without unknowns). `rows`: rows of cells that get them.
template <class Executor>
void restrict_absorbed(const Executor& run, GridView grid, Rows rows) {
  run.for_each(rows.count(), grid.layout.nx, [=] LICHTENBERG_HOST_DEVICE(int row, int i) {
    const int j = rows.begin + row;
    const float sum = gathered(grid.layout, grid.medium.absorbed_groups, i, j,
                               [&](int g, float share) { return grid.cycle.charge[g] * share; });
    if (sum != 0) grid.cycle.f[slot_of(grid.layout, i, j)] += sum;
  });
}

/// Adds the right-hand sides of covered cells to their group's `charge`, and relaxes the groups (bodies with one
/// potential) before the cells use their potentials. Covered cells lie inside conductors.
template <class Executor>
void restrict_charges(const Executor& run, ProblemView problem, GridView grid) {
  sum_by_group(
      run, grid, CellPieces<float>{grid.covered_pieces(problem), grid.covered.slot, grid.cycle.partial},
      [=] LICHTENBERG_HOST_DEVICE(int m) { return grid.cycle.f[grid.covered.slot[m]]; }, parallel::NoAddedValues{},
      [=] LICHTENBERG_HOST_DEVICE(int g, float sum) {
        grid.cycle.charge[g] += sum;
        grid.cycle.phi[g] = grid.cycle.charge[g] * grid.groups.inverse_diagonal[g];
      });
}

/// Computes the potential at the centre of group g by bilinear interpolation between four cells. The group is part of
/// the grid's effective medium (cells whose conductances include small bodies without unknowns). potential(slot)
/// returns a cell's potential; slot: memory index. A group is a set of bodies with one potential.
template <class Potential>
LICHTENBERG_HOST_DEVICE float absorbed_potential(const ProblemView& problem, const GridView& grid, int g,
                                                 Potential potential) {
  const Interpolation around = interpolate(grid.layout, grid.medium.centre[g], problem.electrode);
  float sum = 0;
  for (int k = 0; k < 4; ++k) sum += around.weight[k] * potential(around.cell[k]);
  return sum;
}

/// Computes the potentials phi of groups (bodies with one potential) by interpolation, for the correction of the next
/// finer grid. It does so for groups that are unknowns of that grid and part of this grid's effective medium (cells
/// whose conductances include small bodies without unknowns). `potential`: function of a cell's memory index (slot).
template <class Executor, class Potential>
void interpolate_absorbed(const Executor& run, ProblemView problem, GridView grid, Potential potential) {
  const bool is_divided = grid.layout.is_divided();
  float* mine = is_divided ? values_of_ranks<float>(grid) + run.rank() * grid.capacity[Items::newly_absorbed] : nullptr;
  for_each_item(run, grid, Items::newly_absorbed, [=] LICHTENBERG_HOST_DEVICE(int m) {
    const int g = grid.medium.absorbed_groups.item[m];
    const float phi = absorbed_potential(problem, grid, g, potential);
    if (!is_divided) {
      grid.cycle.phi[g] = phi;
      return;
    }
    const int row = static_cast<int>(grid.medium.centre[g].y), last = grid.layout.ny - 1;
    mine[m] = grid.layout.own.contains(row < 0 ? 0 : row < last ? row : last) ? phi : 0.0f;
  });
  if (!is_divided) return;
  const int* number = grid.number + Items::newly_absorbed;
  add_ranks<float>(run, grid, grid.capacity[Items::newly_absorbed], [=] LICHTENBERG_HOST_DEVICE(int m, float phi) {
    if (m < *number) grid.cycle.phi[grid.medium.absorbed_groups.item[m]] = phi;
  });
}
/// Potential of a cell, by its memory index (slot), with its conductor's potential in a covered cell.
struct PotentialInCell {
  ProblemView problem;
  GridView grid;
  LICHTENBERG_HOST_DEVICE float operator()(std::ptrdiff_t slot) const {
    return potential_at(problem, grid, static_cast<int>(slot));
  }
};

/// Computes the flux from cells to groups (bodies with one potential), with the groups' charges if there are no
/// clusters (groups solved together). If no groups are linked to each other, also computes the groups' new potentials.
/// `z`: also receives these, in double precision; null: unused.
template <class Executor>
void relax_groups(const Executor& run, ProblemView problem, GridView grid, double* z) {
  const bool are_linked = grid.may_link_groups();
  sum_by_group(
      run, grid, links_by_group(problem, grid, grid.cycle.partial),
      [=] LICHTENBERG_HOST_DEVICE(int link) {
        return static_cast<float>(grid.links.conductance[link]) * grid.cycle.v[grid.links.slot[link]];
      },
      parallel::NoAddedValues{},
      [=] LICHTENBERG_HOST_DEVICE(int g, float sum) {
        const float flux = grid.groups.clusters ? sum : grid.cycle.charge[g] + sum;
        if (are_linked) {
          grid.cycle.flux[g] = flux;
          return;
        }
        grid.cycle.phi[g] = flux * grid.groups.inverse_diagonal[g];
        if (z) z[g] = grid.cycle.phi[g];
      });
}

/// Returns the groups' potentials in the first half of a V-cycle; null if there are no groups (bodies with one
/// potential) with unknown potential.
inline const float* potentials_down(const GridView& grid) {
  if (!grid.may_have(Items::unknown_groups)) return nullptr;
  return grid.may_link_groups() ? grid.cycle.phi_down : grid.cycle.phi;
}

/// Completes the right-hand sides of groups (bodies with one potential) on a coarse grid before descend(). On the
/// finest grid StoreResidual sets them instead.
template <class Executor>
void collect(const Executor& run, const ProblemView& problem, const GridView& grid) {
  if (grid.may_have(Items::newly_absorbed)) restrict_absorbed(run, grid, grid.layout.own);
  if (grid.may_have(Items::unknown_groups)) restrict_charges(run, problem, grid);
}

/// Runs a half of a V-cycle on the tiles (rectangles of cells that a thread block takes) of a grid. Small grids get low
/// tiles, others high ones. `Half`: Descend or Ascend.
template <template <int, bool> class Half, class Executor>
void for_each_tile(const Executor& run, const ProblemView& problem, const GridView& grid, const GridView& coarse,
                   const float* phi) {
  constexpr int small = 192;  // cells along a side of the coarse grid: fewer high tiles than processors
  const auto of = [&]<int rows, bool medium>(Half<rows, medium> half) {
    using Of = Half<rows, medium>;
    run.template for_each_block<512, 3>(Of::Tiles::all(grid), Of::bytes, half);
  };
  const bool is_small = coarse.layout.nx <= small;
  if (grid.has_medium)
    is_small ? of(Half<16, true>{problem, grid, coarse, phi}) : of(Half<64, true>{problem, grid, coarse, phi});
  else
    is_small ? of(Half<16, false>{problem, grid, coarse, phi}) : of(Half<64, false>{problem, grid, coarse, phi});
}

/// Relaxes the groups (bodies with one potential) at the start of a V-cycle, from their charges and the fluxes of
/// eliminated cells. An eliminated cell is a fluid cell with a large conductance to a conductor.
template <class Executor>
void relax_groups_first(const Executor& run, const ProblemView& problem, const GridView& grid) {
  if (grid.binds) sum_bound_cells(run, problem, grid);
  if (grid.groups.clusters && grid.binds)
    solve_clusters(run, problem, grid, static_cast<const double*>(grid.cycle.group_rhs), grid.cycle.phi);
  else if (grid.groups.clusters)
    solve_clusters(run, problem, grid, static_cast<const float*>(grid.cycle.charge), grid.cycle.phi);
  if (grid.may_link_groups())
    relax_direct_links(
        run, problem, grid,
        GroupSweep{grid.binds ? grid.cycle.flux : grid.cycle.charge, grid.cycle.phi, nullptr, grid.cycle.phi_down});
}

/// Computes the first half of a V-cycle on a grid: relaxes groups (bodies with one potential), red cells and black
/// cells. Then restricts the residual to the next coarser grid. Leaves in the grid's v the potentials of those cells
/// that the groups' residuals need.
template <class Executor>
void descend(const Executor& run, const ProblemView& problem, const GridView& grid, const GridView& coarse) {
  const float* phi = potentials_down(grid);
  if (phi) relax_groups_first(run, problem, grid);
  for_each_tile<Descend>(run, problem, grid, coarse, phi);
  if (phi) restrict_group_residuals(run, problem, grid, coarse, phi);
}

/// Computes the second half of a V-cycle on a grid, the mirror image of descend(): adds the correction of `coarse`,
/// relaxes black cells, red cells and groups (bodies with one potential). `z`: receives the groups' potentials; null:
/// unused.
template <class Executor>
void ascend(const Executor& run, const ProblemView& problem, const GridView& grid, const GridView& coarse, double* z) {
  const float* phi = potentials_down(grid);
  for_each_tile<Ascend>(run, problem, grid, coarse, phi);
  if (!phi && z) run.fill(z, 0, problem.groups * sizeof(double));
  if (!phi) return;
  relax_groups(run, problem, grid, z);
  if (grid.may_link_groups()) {
    relax_direct_links(run, problem, grid, GroupSweep{grid.cycle.flux, phi, coarse.cycle.phi, grid.cycle.phi_next});
    relax_direct_links(run, problem, grid,
                       GroupSweep{grid.cycle.flux, grid.cycle.phi_next, nullptr, grid.cycle.phi, z});
  }
  if (grid.binds) update_bound_cells(run, grid);
}

}  // namespace lichtenberg::laplace::device
