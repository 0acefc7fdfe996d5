#pragma once

// Steps of nested iteration on the coarse grids for an initial guess without an earlier solution, as
// Multigrid::nested_guess on the CPU. Potentials are in units of `unit` (V).

#include "solvers/laplace/cutcell/device/cycle.hpp"

namespace lichtenberg::laplace::device {

/// Potentials of a coarse grid's solution as source of interpolation. Covered cells (inside conductors) have their
/// conductor's potential, also a given one.
struct CoarsePotentials {
  ProblemView problem;
  GridView grid;
  double unit;

  /// Returns the potential of the cell at the memory index `slot`.
  LICHTENBERG_HOST_DEVICE float cell(int slot) const {
    const CellOwner owner = grid.cells.owner[slot];
    if (owner.is_fluid()) return grid.cycle.v[slot];
    const int g = problem.group_of[owner.body()];
    return problem.floating[g] ? grid.cycle.phi[g] : static_cast<float>(problem.potential[g] / unit);
  }
  /// Returns the potential of cell (i, j), beyond the box that of the nearest cell.
  LICHTENBERG_HOST_DEVICE float at(int i, int j) const {
    const int nx = grid.layout.nx, ny = grid.layout.ny;
    return cell(slot_of(grid.layout, i < 0 ? 0 : i < nx ? i : nx - 1, j < 0 ? 0 : j < ny ? j : ny - 1));
  }
  /// Returns the bilinear interpolation at the centre of cell (i, j) of the next finer grid.
  LICHTENBERG_HOST_DEVICE float interpolate_to(int i, int j) const {
    const int I = i / 2, J = j / 2, s = i % 2 == 0 ? -1 : 1, t = j % 2 == 0 ? -1 : 1;
    return interpolated(at(I, J), at(I + s, J), at(I, J + t), at(I + s, J + t));
  }
};

/// Computes right-hand sides f from the charges of the groups (bodies with one potential) that coarse grids absorb. The
/// charges that the next finer grid has absorbed come by full weighting; those of groups that this grid absorbs are
/// distributed to the cells around. `finer`: that grid; null: no group is absorbed there. Overwrites `charge`.
template <class Executor>
void absorb_charges(const Executor& run, ProblemView problem, const GridView* finer, GridView grid, double unit) {
  if (finer) {
    const GridView fine = *finer;
    run.for_each(grid.layout.ny, grid.layout.nx, [=] LICHTENBERG_HOST_DEVICE(int J, int I) {
      float sum = 0;
      for (int y = -1; y < 3; ++y)
        for (int x = -1; x < 3; ++x) {
          const MirroredCell cell =
              MirroredCell::of(fine.layout.nx, fine.layout.ny, 2 * I + x, 2 * J + y, problem.electrode);
          const float weight = (x == 0 || x == 1 ? 0.75f : 0.25f) * (y == 0 || y == 1 ? 0.75f : 0.25f);
          sum += cell.sign * weight * fine.cycle.f[slot_of(fine.layout, cell.i, cell.j)];
        }
      grid.cycle.f[slot_of(grid.layout, I, J)] = sum;
    });
  } else {
    run.fill(grid.cycle.f, 0, grid.layout.size() * sizeof(float));
  }
  if (!grid.may_have(Items::newly_absorbed)) return;
  run.for_each(problem.groups, [=] LICHTENBERG_HOST_DEVICE(int g) {
    grid.cycle.charge[g] =
        problem.floating[g] ? static_cast<float>(problem.charge[g] / problem.permittivity / unit) : 0.0f;
  });
  restrict_absorbed(run, grid, {0, grid.layout.ny});
}

/// Potential of the electrode sides at the faces of a coarse grid, whose cells are `ratio` cells of the finest grid
/// wide.
struct SidePotential {
  ProblemView problem;
  int ratio;
  /// Returns the potential (V) at face number `face` of a side, counted on the coarse grid.
  LICHTENBERG_HOST_DEVICE double operator()(int side, int face) const {
    const double* finest = problem.side_potential + side * problem.faces + face * ratio;
    return ratio == 1 ? *finest : 0.5 * (finest[ratio / 2 - 1] + finest[ratio / 2]);
  }
};

/// Completes the right-hand sides of a coarse grid, whose f must contain the absorbed charges. Adds the fluxes from
/// given potentials of groups and sides to f, and writes the groups' `charge`. A group is a set of bodies with one
/// potential. `ratio`: width of the grid's cells in cells of the finest grid.
template <class Executor>
void add_given(const Executor& run, ProblemView problem, GridView grid, int ratio, double unit) {
  const SidePotential side_potential{problem, ratio};
  run.for_each(grid.layout.ny, grid.layout.nx, [=] LICHTENBERG_HOST_DEVICE(int j, int i) {
    const int slot = slot_of(grid.layout, i, j);
    const CellOwner owner = grid.cells.owner[slot];
    if (!owner.is_fluid()) return;
    double sum = 0;
    const auto add = [&](int g, float conductance) {
      if (!problem.floating[g]) sum += conductance * problem.potential[g];
      return 0.0f;
    };
    if (owner.is_boundary_cell()) {
      const Coupling* coupling = grid.boundary.coupling + 4 * owner.boundary_number();
      for (int side = 0; side < 4; ++side) add(coupling[side].group, coupling[side].conductance);
    }
    if (grid.may_have(Items::subgrid_conductors)) gathered(grid.layout, grid.medium.subgrid_conductors, i, j, add);
    for (int side = 0; side < 4; ++side)
      if (problem.electrode[side] && !inside(grid.layout, i + step_i(side), j + step_j(side)))
        sum += 2 * (grid.has_medium ? grid.medium.permittivity[slot] : 1.0f) * side_potential(side, side < 2 ? j : i);
    if (sum != 0) grid.cycle.f[slot] += static_cast<float>(sum / unit);
  });
  run.sum_segments(
      problem.groups, [=] LICHTENBERG_HOST_DEVICE(int g) { return grid.direct_links_of(problem, g); },
      [=] LICHTENBERG_HOST_DEVICE(int g, int t) {
        const DirectLink& link = grid.direct.link[grid.first_direct_link(problem, g) + t];
        if (link.is_to_electrode()) {
          // Inherited links have the finest grid's faces.
          const double potential = link.kind == DirectLink::Kind::inherited
                                       ? problem.side_potential[link.face()]
                                       : side_potential(link.face() / problem.faces, link.face() % problem.faces);
          return link.conductance * potential;
        }
        const int other = problem.group_of[link.other];
        return problem.floating[other] ? 0.0 : link.conductance * problem.potential[other];
      },
      [=] LICHTENBERG_HOST_DEVICE(int g, double sum) {
        grid.cycle.charge[g] = grid.groups.diagonal[g] > 0
                                   ? static_cast<float>((problem.charge[g] / problem.permittivity + sum) / unit)
                                   : 0.0f;
      });
}

/// Arrays for the guess of a grid: potentials by slot (memory index) and by group (bodies with one potential).
struct KeptGuess {
  float *v, *phi;
};

/// Interpolates the solution of the next coarser grid to a grid, in `kept` and in the grid's potentials. Replaces the
/// right-hand sides by the residuals of these potentials.
template <class Executor>
void interpolate_guess(const Executor& run, ProblemView problem, CoarsePotentials coarse, GridView grid,
                       KeptGuess kept) {
  run.for_each(problem.groups, [=] LICHTENBERG_HOST_DEVICE(int g) {
    kept.phi[g] = grid.groups.diagonal[g] > 0 ? coarse.grid.cycle.phi[g] : 0.0f;
  });
  run.for_each(grid.layout.ny, grid.layout.nx, [=] LICHTENBERG_HOST_DEVICE(int j, int i) {
    const int slot = slot_of(grid.layout, i, j);
    kept.v[slot] = grid.cycle.v[slot] = grid.cells.inverse_diagonal[slot] > 0 ? coarse.interpolate_to(i, j) : 0.0f;
  });
  run.for_each(grid.layout.ny, grid.layout.nx, [=] LICHTENBERG_HOST_DEVICE(int j, int i) {
    const int slot = slot_of(grid.layout, i, j);
    const float inverse = grid.cells.inverse_diagonal[slot], *v = grid.cycle.v;
    if (!(inverse > 0)) return;  // A covered cell keeps the charge that its group receives.
    const Neighbours n = neighbours(grid.layout, slot);
    const float *east = grid.medium.east, *north = grid.medium.north;
    const float flux = grid.has_medium ? east[n.west] * v[n.west] + east[slot] * v[n.east] +
                                             north[n.south] * v[n.south] + north[slot] * v[n.north]
                                       : v[n.west] + v[n.east] + v[n.south] + v[n.north];
    grid.cycle.f[slot] += flux + group_sums(grid, slot, i, j, kept.phi, nullptr).one - v[slot] / inverse;
  });
  sum_by_group(
      run, grid, links_by_group(problem, grid, grid.cycle.partial),
      [=] LICHTENBERG_HOST_DEVICE(int link) {
        return static_cast<float>(grid.links.conductance[link]) * grid.cycle.v[grid.links.slot[link]];
      },
      DirectFluxes<float>{problem, grid, kept.phi},
      [=] LICHTENBERG_HOST_DEVICE(int g, float sum) {
        const auto diagonal = static_cast<float>(grid.groups.diagonal[g]);
        grid.cycle.charge[g] = diagonal > 0 ? grid.cycle.charge[g] + sum - diagonal * kept.phi[g] : 0.0f;
      });
}

/// Adds the kept guess to the correction that a V-cycle has left in the potentials of cells and groups (bodies with one
/// potential).
template <class Executor>
void add_guess(const Executor& run, ProblemView problem, GridView grid, KeptGuess kept) {
  const int cells = static_cast<int>(grid.layout.size());
  run.for_each(cells + static_cast<long>(problem.groups), [=] LICHTENBERG_HOST_DEVICE(int k) {
    if (k < cells) {
      if (grid.cells.inverse_diagonal[k] > 0) grid.cycle.v[k] += kept.v[k];
    } else if (const int g = k - cells; grid.groups.diagonal[g] > 0) {
      grid.cycle.phi[g] += kept.phi[g];
    }
  });
}

/// Computes the potentials phi of the groups (bodies with one potential) that a coarse grid absorbs but the next finer
/// one does not, by interpolation from its solution.
template <class Executor>
void interpolate_absorbed_guess(const Executor& run, ProblemView problem, CoarsePotentials coarse) {
  const GridView grid = coarse.grid;
  if (!grid.may_have(Items::newly_absorbed)) return;
  interpolate_absorbed(run, problem, grid, [=] LICHTENBERG_HOST_DEVICE(std::ptrdiff_t slot) {
    return coarse.cell(static_cast<int>(slot));
  });
}

/// Interpolates the solution of the first coarse grid to the unknowns x of the finest grid, by slot (memory index),
/// then by group (bodies with one potential).
template <class Executor>
void interpolate_to_finest(const Executor& run, ProblemView problem, CoarsePotentials coarse, GridView grid,
                           double* x) {
  const int cells = static_cast<int>(grid.layout.size());
  run.for_each(cells, [=] LICHTENBERG_HOST_DEVICE(int slot) {
    double value = 0;
    if (grid.cells.inverse_diagonal[slot] > 0) {
      const CellIndex cell = cell_of(grid.layout, slot);
      value = coarse.interpolate_to(cell.i, cell.j);
    }
    x[slot] = value;
  });
  run.for_each(problem.groups, [=] LICHTENBERG_HOST_DEVICE(int g) {
    x[cells + g] = grid.groups.diagonal[g] > 0 ? coarse.grid.cycle.phi[g] : 0.0f;
  });
}

}  // namespace lichtenberg::laplace::device
