#pragma once

// Large grids of the V-cycle, with a kernel per step: the halves of tiles.hpp, and the steps of groups before and after
// them.

#include "solvers/laplace/cutcell/device/bound.hpp"
#include "solvers/laplace/cutcell/device/relax_clusters.hpp"
#include "solvers/laplace/cutcell/device/tiles.hpp"

namespace lichtenberg::laplace::device {

/// Sets z from v and phi if there is only one grid; 0 in covered cells.
template <class Executor>
void copy_potentials(const Executor& run, ProblemView problem, GridView grid, const float* v, double* z) {
  const int cells = static_cast<int>(grid.layout.size());
  run.for_each(cells, [=] LICHTENBERG_HOST_DEVICE(int k) { z[k] = grid.cells.inverse_diagonal[k] > 0 ? v[k] : 0.0; });
  run.for_each(problem.groups, [=] LICHTENBERG_HOST_DEVICE(int g) { z[cells + g] = grid.cycle.phi[g]; });
}

/// Stores an entry of the residual as f or, after the cells, as a group's charge, and relaxes the group.
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

template <class Executor>
void store_residual(const Executor& run, ProblemView problem, GridView grid, const double* r) {
  const StoreResidual take{grid};
  run.for_each(static_cast<long>(grid.layout.size()) + problem.groups,
               [=] LICHTENBERG_HOST_DEVICE(int k) { take(k, r[k]); });
}

/// Flux to a group through direct links with other groups, for sums over its links. Groups of given potential have 0 in
/// `phi`: they are on the right-hand side.
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

/// Jacobi sweep over groups with direct links: (flux + flux through direct links) / diagonal; clusters are relaxed as
/// one.
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

/// Computes the groups' residuals after the first half of the V-cycle, as charges of the coarse grid;
/// restrict_charges() adds those of its cells. A cluster was in balance when it was relaxed, so that only later changes
/// count.
template <class V, class Executor>
void restrict_group_residuals(const Executor& run, ProblemView problem, GridView fine, GridView coarse,
                              const float* phi, const V* v) {
  const auto flux = [=] LICHTENBERG_HOST_DEVICE(int link) {
    return static_cast<float>(fine.links.conductance[link]) * static_cast<float>(v[fine.links.slot[link]]);
  };
  const float* before = fine.groups.clusters ? fine.cycle.phi : nullptr;
  run.sum_pieces(fine.link_pieces(problem), fine.cycle.partial, flux, CycleFluxes{problem, fine, phi, nullptr, before},
                 [=] LICHTENBERG_HOST_DEVICE(int g, float sum) {
                   const float inverse = fine.groups.inverse_diagonal[g];
                   float residual = sum + (fine.cycle.charge[g] - phi[g] / inverse);
                   if (before && fine.groups.clusters->row[g] >= 0)
                     residual = fine.binds ? sum - fine.cycle.flux[g] : sum;
                   coarse.cycle.charge[g] = inverse > 0 ? residual : 0.0f;
                 });
}

/// Distributes the residuals of groups that this grid absorbs first to the four cells around each.
template <class Executor>
void restrict_absorbed(const Executor& run, GridView grid) {
  run.for_each(grid.layout.ny, grid.layout.nx, [=] LICHTENBERG_HOST_DEVICE(int j, int i) {
    const float sum = gathered(grid.layout, grid.medium.absorbed_groups, i, j,
                               [&](int g, float share) { return grid.cycle.charge[g] * share; });
    if (sum != 0) grid.cycle.f[slot_of(grid.layout, i, j)] += sum;
  });
}

/// Adds the charges of covered cells to their group's charge, and relaxes the groups before the cells use their
/// potentials.
template <class Executor>
void restrict_charges(const Executor& run, ProblemView problem, GridView grid) {
  run.sum_pieces(
      grid.covered_pieces(problem), grid.cycle.partial,
      [=] LICHTENBERG_HOST_DEVICE(int m) { return grid.cycle.f[grid.covered.slot[m]]; }, parallel::NoAddedValues{},
      [=] LICHTENBERG_HOST_DEVICE(int g, float sum) {
        grid.cycle.charge[g] += sum;
        grid.cycle.phi[g] = grid.cycle.charge[g] * grid.groups.inverse_diagonal[g];
      });
}

/// Returns the potential of an absorbed group, interpolated between the four cells around it: potential(slot).
template <class Potential>
LICHTENBERG_HOST_DEVICE float absorbed_potential(const ProblemView& problem, const GridView& grid, int g,
                                                 Potential potential) {
  const Interpolation around = interpolate(grid.layout, grid.medium.centre[g], problem.electrode);
  float sum = 0;
  for (int k = 0; k < 4; ++k) sum += around.weight[k] * potential(around.cell[k]);
  return sum;
}

template <class Executor>
void interpolate_absorbed(const Executor& run, ProblemView problem, GridView grid) {
  for_each_item(run, grid, Items::newly_absorbed, [=] LICHTENBERG_HOST_DEVICE(int m) {
    const int g = grid.medium.absorbed_groups.item[m];
    grid.cycle.phi[g] = absorbed_potential(
        problem, grid, g, [&](std::ptrdiff_t slot) { return potential_at(problem, grid, static_cast<int>(slot)); });
  });
}

/// Computes the flux from cells to groups, with the groups' charges if there are no clusters. Without direct links it
/// gives the groups' potentials. `z`: becomes the potentials too; null: unused.
template <class V, class Executor>
void relax_groups(const Executor& run, ProblemView problem, GridView grid, const V* v, double* z) {
  const bool are_linked = grid.may_link_groups();
  run.sum_pieces(
      grid.link_pieces(problem), grid.cycle.partial,
      [=] LICHTENBERG_HOST_DEVICE(int link) {
        return static_cast<float>(grid.links.conductance[link]) * static_cast<float>(v[grid.links.slot[link]]);
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

/// Returns the groups' potentials in the first half of a V-cycle; null if there are none.
inline const float* potentials_down(const GridView& grid) {
  if (!grid.may_have(Items::unknown_groups)) return nullptr;
  return grid.may_link_groups() ? grid.cycle.phi_down : grid.cycle.phi;
}

/// Restricts charges before descend(), except on the finest grid, where StoreResidual sets the residual.
template <class Executor>
void collect(const Executor& run, const ProblemView& problem, const GridView& grid) {
  if (grid.may_have(Items::newly_absorbed)) restrict_absorbed(run, grid);
  if (grid.may_have(Items::unknown_groups)) restrict_charges(run, problem, grid);
}

/// Calls f with the tiling for a grid.
template <class F>
void with_tiles(const GridView& coarse, F f) {
  constexpr int small = 192;  // cells along a side of the coarse grid: fewer large tiles than processors
  if (coarse.layout.nx <= small)
    f(Tiling<16, 8>{});
  else
    f(Tiling<32, 16>{});
}

/// Relaxes groups first, from their charges and the fluxes of eliminated cells.
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

/// First half of a V-cycle on a grid: relaxes groups, red cells and black cells, and computes the residual for the next
/// coarser grid.
template <class V, class Executor>
void descend(const Executor& run, const ProblemView& problem, const GridView& grid, const GridView& coarse, V* v) {
  const float* phi = potentials_down(grid);
  if (phi) relax_groups_first(run, problem, grid);
  with_tiles(coarse, [&](auto tiles) {
    using Tiles = decltype(tiles);
    using Half = Descend<V, Tiles>;
    run.template for_each_block<512>(Tiles::all(coarse), Half::bytes(grid), Half{problem, grid, coarse, phi, v});
  });
  if (phi) restrict_group_residuals(run, problem, grid, coarse, phi, static_cast<const V*>(v));
}

/// Second half of a V-cycle on a grid, the mirror image of descend(): relaxes black cells, red cells, groups. `z`:
/// becomes the groups' potentials; null: unused.
template <class V, class Executor>
void ascend(const Executor& run, const ProblemView& problem, const GridView& grid, const GridView& coarse, V* v,
            double* z) {
  const float* phi = potentials_down(grid);
  with_tiles(coarse, [&](auto tiles) {
    using Tiles = decltype(tiles);
    using Half = Ascend<V, Tiles>;
    run.template for_each_block<512>(Tiles::all(coarse), Half::bytes(grid), Half{problem, grid, coarse, phi, v});
  });
  if (!phi && z) run.fill(z, 0, problem.groups * sizeof(double));
  if (!phi) return;
  relax_groups(run, problem, grid, static_cast<const V*>(v), z);
  if (grid.may_link_groups()) {
    relax_direct_links(run, problem, grid, GroupSweep{grid.cycle.flux, phi, coarse.cycle.phi, grid.cycle.phi_next});
    relax_direct_links(run, problem, grid,
                       GroupSweep{grid.cycle.flux, grid.cycle.phi_next, nullptr, grid.cycle.phi, z});
  }
  if (grid.binds) update_bound_cells(run, grid, v);
}

}  // namespace lichtenberg::laplace::device
