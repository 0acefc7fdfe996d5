#pragma once

// Small grids of the V-cycle in one block and its fast memory: a loop takes less time than a kernel. Memory holds the
// values that tiles.hpp computes again for each tile.

#include "solvers/laplace/cutcell/device/cycle.hpp"

namespace lichtenberg::laplace::device {

/// Position of a small grid's cells in a block's memory, in the order of Layout.
struct SmallGrid {
  int nx = 0, ny = 0, stride = 0, colour_size = 0;
  /// Start of the grid's arrays in the memory (number of floats).
  int begin = 0;
  bool medium = false;

  SmallGrid() = default;
  SmallGrid(const Layout& at, bool medium_, int begin_)
      : nx(at.nx),
        ny(at.ny),
        stride(static_cast<int>(at.stride)),
        colour_size(static_cast<int>(at.colour_size())),
        begin(begin_),
        medium(medium_) {}
  LICHTENBERG_HOST_DEVICE int size() const { return 2 * colour_size; }
  /// Returns the end of the grid's arrays in the memory (number of floats).
  int end() const { return begin + (medium ? 5 : 3) * size(); }
};

/// Kernel for the V-cycle on all small grids, numbers `first` to `last`, by one thread block in its fast memory. The
/// last one is the coarsest grid, solved by its inverse matrix.
struct SmallGrids {
  static constexpr int most = 12, threads = 1024;

  ProblemView problem;
  /// Views of all grids, in device memory.
  const GridView* grid;
  int first, last;
  /// Unknowns of the coarsest grid (CoarsestView::unknown).
  const int* unknown;
  /// Inverse matrix of the coarsest grid in single precision.
  const float* inverse;
  /// Inverse matrix in double precision; if not null, used in place of `inverse`.
  const double* precise_inverse;
  /// Small grids, from number `first` on.
  SmallGrid small[most];

  /// Returns the size of the block's memory (bytes).
  std::size_t bytes() const { return small[last - first].end() * sizeof(float); }

  /// Runs the V-cycle on the grids from number `first` on, which fit into a block's fast memory, from the residual on
  /// grid `first` to its potentials v.
  template <class Block>
  LICHTENBERG_HOST_DEVICE void operator()(const Block& block, int) const {
    for (int l = first; l <= last; ++l) load(block, l);
    for (int l = first; l < last; ++l) {
      collect(block, l);
      descend(block, l);
    }
    collect(block, last);
    solve(block);
    finish(block, last);
    for (int l = last - 1; l >= first; --l) {
      ascend(block, l);
      finish(block, l);
    }
    const Cells finest(block, *this, first);
    float* v = grid[first].cycle.v;
    block.each(small[0].size(), [&](int slot) { v[slot] = finest.v[slot]; });
  }

 private:
  /// Pointers to the arrays of a small grid in the block's memory.
  struct Cells {
    float *v, *f, *inverse, *east, *north;
    int nx, ny, stride, colour_size;
    bool medium;

    template <class Block>
    LICHTENBERG_HOST_DEVICE Cells(const Block& block, const SmallGrids& all, int l) {
      const SmallGrid& own = all.small[l - all.first];
      v = block.template memory<float>() + own.begin;
      f = v + own.size();
      inverse = f + own.size();
      east = inverse + own.size();
      north = east + own.size();
      nx = own.nx, ny = own.ny, stride = own.stride, colour_size = own.colour_size, medium = own.medium;
    }
    /// Returns the memory index of cell number m of a colour in row j.
    LICHTENBERG_HOST_DEVICE int slot(int colour, int j, int m) const {
      return colour * colour_size + (j + 1) * stride + Layout::pad + m;
    }
    LICHTENBERG_HOST_DEVICE int slot_at(int i, int j) const { return slot((i + j) & 1, j, i >> 1); }
    /// Returns the flux from the four neighbours to a cell.
    LICHTENBERG_HOST_DEVICE float flux(int colour, int j, int m) const {
      const int own = slot(colour, j, m), beside = slot(1 - colour, j, m);
      const int to_east = beside + ((colour + j) & 1), to_west = to_east - 1;
      const int south = beside - stride, to_north = beside + stride;
      if (!medium) return v[to_west] + v[to_east] + v[south] + v[to_north];
      return east[to_west] * v[to_west] + east[own] * v[to_east] + north[south] * v[south] + north[own] * v[to_north];
    }
    /// Calls of(colour, row, number) for all cells.
    template <class Block, class F>
    LICHTENBERG_HOST_DEVICE void each(const Block& block, F of) const {
      block.each(2 * ny, nx / 2, [&](int row, int m) { of(row >= ny, row >= ny ? row - ny : row, m); });
    }
    /// Calls of(slot, row, m) for the cells of a colour, with m their number in the row. A slot is the memory index of
    /// a cell.
    template <class Block, class F>
    LICHTENBERG_HOST_DEVICE void each_of(const Block& block, int colour, F of) const {
      block.each(ny, nx / 2, [&](int row, int m) { of(slot(colour, row, m), row, m); });
    }
  };

  /// Loads the data of the cells of grid `l` into the block's memory.
  template <class Block>
  LICHTENBERG_HOST_DEVICE void load(const Block& block, int l) const {
    const Cells here(block, *this, l);
    const GridView& from = grid[l];
    const float *f = from.cycle.f, *inverse_diagonal = from.cells.inverse_diagonal;
    const float *east = from.medium.east, *north = from.medium.north;
    block.template each<4>(2 * here.colour_size, [&](int slot) {
      here.v[slot] = 0;
      here.f[slot] = l == first ? f[slot] : 0.0f;
      here.inverse[slot] = inverse_diagonal[slot];
      if (!here.medium) return;
      here.east[slot] = east[slot];
      here.north[slot] = north[slot];
    });
  }

  /// Returns true if grid l has items of this kind.
  LICHTENBERG_HOST_DEVICE bool has(int l, Items::Kind kind) const { return grid[l].number[kind] > 0; }
  LICHTENBERG_HOST_DEVICE static parallel::SegmentList own_groups(const GridView& here) {
    return {here.groups.own, here.number[Items::own_groups]};
  }
  LICHTENBERG_HOST_DEVICE bool links_groups(int l) const {
    return grid[l].groups.clusters || has(l, Items::direct_links);
  }

  /// Distributes the residuals (`charge`) of groups that become part of grid l's effective medium to the right-hand
  /// sides f of the four cells around. An effective medium contains small bodies without unknowns in its conductances.
  /// Adds f of covered cells (inside conductors) to the `charge` of their group. Then relaxes the groups, before the
  /// cells use their potentials. A group is a set of bodies with one potential.
  template <class Block>
  LICHTENBERG_HOST_DEVICE void collect(const Block& block, int l) const {
    const GridView& here = grid[l];
    const Cells cells(block, *this, l);
    float *charge = here.cycle.charge, *phi = here.cycle.phi;
    if (has(l, Items::newly_absorbed)) {
      const Bins bins = here.medium.absorbed_groups;
      block.each(cells.ny, cells.nx, [&](int j, int i) {
        const float sum = gathered(here.layout, bins, i, j, [&](int g, float share) { return charge[g] * share; });
        if (sum != 0) cells.f[cells.slot_at(i, j)] += sum;
      });
    }
    if (!has(l, Items::unknown_groups)) return;
    const int *covered = here.covered.slot, *own = here.groups.own, n = here.number[Items::own_groups];
    const float* inverse_diagonal = here.groups.inverse_diagonal;
    block.sum_pieces(
        here.covered_pieces(problem), own_groups(here), here.cycle.partial, [&](int m) { return cells.f[covered[m]]; },
        parallel::NoAddedValues{},
        [&](int g, float sum) {
          charge[g] += sum;
          phi[g] = charge[g] * inverse_diagonal[g];
        });
    if (!links_groups(l)) return;
    float* next = here.cycle.phi_next;
    if (here.groups.clusters) solve_clusters(block, here, charge, phi);
    relax_direct_links(block, here, charge, phi, next);
    float* before = here.cycle.phi_down;
    block.each(n, [&](int k) {
      before[own[k]] = phi[own[k]];
      phi[own[k]] = next[own[k]];
    });
  }

  /// Solves for the groups' potentials phi, clusters (groups with strong links) together, as on large grids
  /// (relax_clusters.hpp). A group is a set of bodies with one potential.
  template <class Block, class Real>
  LICHTENBERG_HOST_DEVICE void solve_clusters(const Block& block, const GridView& here, const Real* rhs,
                                              float* phi) const {
    const int* own = here.groups.own;
    const ClusterView& clusters = *here.groups.clusters;
    block.sum_segments(
        here.number[Items::own_groups], [&](int k) { return clusters.size_of(own[k]); },
        [&](int k, int t) { return clusters.value(own[k], t, rhs); },
        [&](int k, double sum) {
          const int g = own[k];
          phi[g] = clusters.row[g] < 0 ? rhs[g] * here.groups.inverse_diagonal[g] : static_cast<float>(sum);
        });
  }

  /// Relaxes the groups' potentials by one Jacobi sweep: next = (flux + flux from other groups) / diagonal. Clusters
  /// (groups with strong links) are solved together instead. A group is a set of bodies with one potential.
  template <class Block>
  LICHTENBERG_HOST_DEVICE void relax_direct_links(const Block& block, const GridView& here, const float* flux,
                                                  const float* phi, float* next) const {
    const int* own = here.groups.own;
    if (here.groups.clusters) {
      const CycleFluxes outside{problem, here, phi};
      block.sum_segments(
          here.number[Items::own_groups], [&](int k) { return outside.count(own[k]); },
          [&](int k, int t) { return outside.value(own[k], t); },
          [&](int k, float sum) {
            const int g = own[k];
            here.cycle.group_rhs[g] =
                static_cast<double>(here.cycle.charge[g]) + (flux == here.cycle.charge ? sum : flux[g] + sum);
          });
      return solve_clusters(block, here, here.cycle.group_rhs, next);
    }
    const CycleFluxes fluxes{problem, here, phi};
    block.sum_segments(
        here.number[Items::own_groups], [&](int k) { return here.direct_links_of(problem, own[k]); },
        [&](int k, int t) { return fluxes.value(own[k], t); },
        [&](int k, float sum) { next[own[k]] = (flux[own[k]] + sum) * here.groups.inverse_diagonal[own[k]]; });
  }

  /// Flux from groups (bodies with one potential) to a cell: sum of conductance times group potential over the cell's
  /// links; 0 without unknown groups.
  struct FromGroups {
    const CellOwner* owner;
    const Coupling* coupling;
    Bins thin;
    Layout layout;
    const float* phi;
    bool any, any_thin;

    LICHTENBERG_HOST_DEVICE FromGroups(const SmallGrids& all, int l, const float* phi_)
        : owner(all.grid[l].cells.owner),
          coupling(all.grid[l].boundary.coupling),
          thin(all.grid[l].medium.subgrid_conductors),
          layout(all.grid[l].layout),
          phi(phi_),
          any(all.has(l, Items::unknown_groups)),
          any_thin(all.has(l, Items::floating_subgrid_conductors)) {}
    LICHTENBERG_HOST_DEVICE float operator()(int slot, int i, int j) const {
      float sum = 0;
      if (!any) return sum;
      if (const CellOwner own = owner[slot]; own.is_boundary_cell())
        for (int k = 4 * own.boundary_number(), end = k + 4; k < end; ++k)
          sum += coupling[k].conductance * phi[coupling[k].group];
      if (any_thin) sum += gathered(layout, thin, i, j, [&](int g, float conductance) { return conductance * phi[g]; });
      return sum;
    }
  };

  /// Computes the first half of the V-cycle on grid l: relaxes the cells and restricts the residuals to grid l + 1.
  template <class Block>
  LICHTENBERG_HOST_DEVICE void descend(const Block& block, int l) const {
    const Cells cells(block, *this, l);
    const FromGroups from_groups(*this, l, grid[l].cycle.phi);
    cells.each(block, [&](int colour, int j, int m) {
      const int slot = cells.slot(colour, j, m);
      const float f = cells.f[slot] + from_groups(slot, 2 * m + ((colour + j) & 1), j);
      cells.f[slot] = f;
      if (colour == 0) cells.v[slot] = f * cells.inverse[slot];
    });
    cells.each_of(block, 1, [&](int slot, int j, int m) {
      cells.v[slot] = (cells.f[slot] + cells.flux(1, j, m)) * cells.inverse[slot];
    });
    // A red cell's residual is the flux from its black neighbours; it replaces the cell's potential.
    cells.each_of(block, 0, [&](int slot, int j, int m) {
      cells.v[slot] = cells.inverse[slot] > 0 ? cells.flux(0, j, m) : 0.0f;
    });
    restrict_residual(block, l);
    if (!has(l, Items::unknown_groups)) return;
    const GridView& fine = grid[l];
    const int black = cells.colour_size, *link_slot = fine.links.slot;
    const double* conductance = fine.links.conductance;
    const float *charge = fine.cycle.charge, *phi = fine.cycle.phi, *inverse_diagonal = fine.groups.inverse_diagonal;
    float* coarse_charge = grid[l + 1].cycle.charge;
    const auto flux = [&](int link) {
      const int slot = link_slot[link];
      const float value = slot < black ? cells.f[slot] * cells.inverse[slot] : cells.v[slot];
      return static_cast<float>(conductance[link]) * value;
    };
    const ClusterView* clusters = fine.groups.clusters;
    const float* before = clusters ? fine.cycle.phi_down : nullptr;
    block.sum_pieces(fine.link_pieces(problem), own_groups(fine), fine.cycle.partial, flux,
                     CycleFluxes{problem, fine, phi, nullptr, before}, [&](int g, float sum) {
                       const bool in_cluster = clusters && clusters->row[g] >= 0;
                       coarse_charge[g] = in_cluster ? sum : sum + (charge[g] - phi[g] / inverse_diagonal[g]);
                     });
  }

  /// Computes the right-hand side f of grid l + 1 from the residual of grid l by full weighting.
  template <class Block>
  LICHTENBERG_HOST_DEVICE void restrict_residual(const Block& block, int l) const {
    const Cells fine(block, *this, l), coarse(block, *this, l + 1);
    block.each(coarse.ny, coarse.nx, [&](int J, int I) {
      coarse.f[coarse.slot_at(I, J)] = full_weighting(problem, coarse.nx, coarse.ny, I, J, [&](int x, int y) {
        return fine.v[fine.slot(0, 2 * J + y, (2 * I + x) >> 1)];
      });
    });
  }

  /// Solves the coarsest grid: computes v and phi of its unknowns from f and `charge` by the inverse matrix.
  template <class Block>
  LICHTENBERG_HOST_DEVICE void solve(const Block& block) const {
    const Cells cells(block, *this, last);
    const int n = grid[last].number[Items::coarse_unknowns];
    const float* charge = grid[last].cycle.charge;
    float* phi = grid[last].cycle.phi;
    const auto solve_by = [&](const auto* inverse_matrix) {
      block.template sum_segments<32>(
          n, [&](int) { return n; },
          [&](int a, int b) {
            const int name = unknown[b];
            return inverse_matrix[a * n + b] * (name >= 0 ? cells.f[name] : charge[-1 - name]);
          },
          [&](int a, auto sum) {
            (unknown[a] >= 0 ? cells.v[unknown[a]] : phi[-1 - unknown[a]]) = static_cast<float>(sum);
          });
    };
    precise_inverse ? solve_by(precise_inverse) : solve_by(inverse);
  }

  /// Prepares grid l as source of bilinear interpolation. Sets covered cells (inside conductors) to their group's
  /// potential. Interpolates the potentials of groups that become part of the effective medium (cells whose
  /// conductances include small bodies without unknowns) on grid l. A group is a set of bodies with one potential.
  template <class Block>
  LICHTENBERG_HOST_DEVICE void finish(const Block& block, int l) const {
    const GridView& here = grid[l];
    const Cells cells(block, *this, l);
    const int *covered = here.covered.slot, *group = here.covered.group;
    float* phi = here.cycle.phi;
    block.each(here.number[Items::covered], [&](int m) { cells.v[covered[m]] = phi[group[m]]; });
    if (!has(l, Items::newly_absorbed)) return;
    block.each(here.number[Items::newly_absorbed], [&](int m) {
      const int g = here.medium.absorbed_groups.item[m];
      phi[g] = absorbed_potential(problem, here, g, [&](std::ptrdiff_t slot) { return cells.v[slot]; });
    });
  }

  /// Computes the second half of the V-cycle on grid l: adds the correction of grid l + 1, relaxes cells and groups
  /// (bodies with one potential).
  template <class Block>
  LICHTENBERG_HOST_DEVICE void ascend(const Block& block, int l) const {
    const Cells cells(block, *this, l), coarse(block, *this, l + 1);
    const FromGroups from_groups(*this, l, grid[l + 1].cycle.phi);
    // The flux from the coarse grid's groups is added after the red cells' f has been used.
    const auto add = [&](int slot, int colour, int j, int m) {
      cells.f[slot] += from_groups(slot, 2 * m + ((colour + j) & 1), j);
    };
    cells.each(block, [&](int colour, int j, int m) {
      const int slot = cells.slot(colour, j, m);
      if (colour == 1) return add(slot, 1, j, m);
      const int s = j & 1 ? 1 : -1, J = j / 2;
      cells.v[slot] = cells.inverse[slot] > 0 ? cells.f[slot] * cells.inverse[slot] +
                                                    interpolated(beyond(coarse, m, J), beyond(coarse, m + s, J),
                                                                 beyond(coarse, m, J + s), beyond(coarse, m + s, J + s))
                                              : 0.0f;
    });
    cells.each(block, [&](int colour, int j, int m) {
      const int slot = cells.slot(colour, j, m);
      if (colour == 0) return add(slot, 0, j, m);
      cells.v[slot] = (cells.f[slot] + cells.flux(1, j, m)) * cells.inverse[slot];
    });
    cells.each_of(block, 0, [&](int slot, int j, int m) {
      cells.v[slot] = (cells.f[slot] + cells.flux(0, j, m)) * cells.inverse[slot];
    });
    if (has(l, Items::unknown_groups)) relax_groups(block, l);
  }

  /// Relaxes the groups' potentials on grid l at the end of its part of the V-cycle. A group is a set of bodies with
  /// one potential.
  template <class Block>
  LICHTENBERG_HOST_DEVICE void relax_groups(const Block& block, int l) const {
    const GridView& here = grid[l];
    const Cells cells(block, *this, l);
    const bool are_linked = links_groups(l);
    const int* link_slot = here.links.slot;
    const double* conductance = here.links.conductance;
    const float *charge = here.cycle.charge, *coarse_phi = grid[l + 1].cycle.phi,
                *inverse_diagonal = here.groups.inverse_diagonal;
    float *flux = here.cycle.flux, *phi = here.cycle.phi, *next = here.cycle.phi_next;
    block.sum_pieces(
        here.link_pieces(problem), own_groups(here), here.cycle.partial,
        [&](int link) { return static_cast<float>(conductance[link]) * cells.v[link_slot[link]]; },
        parallel::NoAddedValues{},
        [&](int g, float sum) {
          flux[g] = here.groups.clusters ? sum : charge[g] + sum;
          phi[g] = are_linked ? phi[g] + coarse_phi[g] : flux[g] * inverse_diagonal[g];
        });
    if (!are_linked) return;
    relax_direct_links(block, here, flux, phi, next);
    relax_direct_links(block, here, flux, next, phi);
  }

  /// Returns the potential of cell (i, j); beyond the box that of its mirror image, with opposite sign at an electrode.
  LICHTENBERG_HOST_DEVICE float beyond(const Cells& cells, int i, int j) const {
    const MirroredCell cell = MirroredCell::of(cells.nx, cells.ny, i, j, problem.electrode);
    return cell.sign * cells.v[cells.slot_at(cell.i, cell.j)];
  }
};

}  // namespace lichtenberg::laplace::device
