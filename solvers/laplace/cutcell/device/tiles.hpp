#pragma once

// Cells of a large grid in the V-cycle, one tile per block. Each half of a cycle is one kernel, which computes the
// cells that tiles share once per tile. V is the type of the potentials: double on the finest grid, whose potentials
// are the preconditioned residual, else float. The arithmetic is in single precision.
//
// In the first half, red cells (colour 0) contain f / diagonal. Black cells are relaxed, which leaves residuals in red
// cells only. In the second half, black cells are relaxed after the red cells have received the coarse correction; red
// cells are last. Fluxes from groups are computed where they are needed and never added to f.

#include "solvers/laplace/cutcell/device/homogenized.hpp"

namespace lichtenberg::laplace::device {

/// Sums over a cell's links to groups (bodies with one potential): conductance times the group's potential, for two
/// vectors of potentials.
struct GroupSums {
  float one = 0, other = 0;
};

/// Computes the flux from groups (bodies with one potential) to cell (i, j): sums of conductance times potential for
/// the group potentials `one` and `other`. `other` may be null. `slot`: the cell's memory index.
LICHTENBERG_HOST_DEVICE inline GroupSums group_sums(const GridView& grid, int slot, int i, int j, const float* one,
                                                    const float* other) {
  GroupSums sum;
  const auto add = [&](int group, float conductance) {
    sum.one += conductance * one[group];
    if (other) sum.other += conductance * other[group];
    return 0.0f;
  };
  if (const CellOwner owner = grid.cells.owner[slot]; owner.is_boundary_cell()) {
    const Coupling* coupling = grid.boundary.coupling + 4 * owner.boundary_number();
    for (int side = 0; side < 4; ++side) add(coupling[side].group, coupling[side].conductance);
  }
  if (grid.may_have(Items::floating_subgrid_conductors))
    gathered(grid.layout, grid.medium.subgrid_conductors, i, j, add);
  return sum;
}

/// Returns true if the V-cycle eliminates the fluid cell at the memory index `slot` (a near-surface cell). An
/// eliminated cell is a fluid cell with a large conductance to a conductor.
LICHTENBERG_HOST_DEVICE inline bool is_eliminated(const GridView& grid, int slot) {
  const CellOwner owner = grid.cells.owner[slot];
  return owner.is_boundary_cell() && grid.bound.is_eliminated[owner.boundary_number()];
}

/// Cells of a tile of the grid, with a border (halo) on all sides, in a block's memory. The lower left cell is red.
template <int width_, int height_>
struct Tile {
  static constexpr int width = width_, height = height_, cells = width * height;
  float *inverse, *f, *value, *more, *east, *north;
  bool medium;

  /// Returns the size of a tile's memory (bytes). `medium`: with conductances of faces.
  static constexpr std::size_t bytes(bool medium) { return (medium ? 6 : 4) * cells * sizeof(float); }
  LICHTENBERG_HOST_DEVICE Tile(float* memory, bool medium_)
      : inverse(memory),
        f(memory + cells),
        value(memory + 2 * cells),
        more(memory + 3 * cells),
        east(memory + 4 * cells),
        north(memory + 5 * cells),
        medium(medium_) {}

  /// Returns the flux from the four neighbours to an inner cell.
  LICHTENBERG_HOST_DEVICE float flux(int at) const {
    if (!medium) return value[at - 1] + value[at + 1] + value[at - width] + value[at + width];
    return east[at - 1] * value[at - 1] + east[at] * value[at + 1] + north[at - width] * value[at - width] +
           north[at] * value[at + width];
  }
  /// Loads the data of cell (i, j), except its potential, into the tile's entry `at`; beyond the box, loads zeros.
  /// `phi`: potentials of the groups (bodies with one potential); `more_phi`: potentials to be added later, whose
  /// fluxes are kept apart. Both may be null.
  LICHTENBERG_HOST_DEVICE void load(const GridView& grid, int at, int i, int j, const float* phi,
                                    const float* more_phi) const {
    const bool is_inside = inside(grid.layout, i, j);
    const int slot = is_inside ? slot_of(grid.layout, i, j) : 0;
    inverse[at] = is_inside ? grid.cells.inverse_diagonal[slot] : 0.0f;
    f[at] = more[at] = 0;
    if (medium) {
      east[at] = is_inside ? grid.medium.east[slot] : 0.0f;
      north[at] = is_inside ? grid.medium.north[slot] : 0.0f;
    }
    if (!is_inside) return;
    const GroupSums from_groups = phi ? group_sums(grid, slot, i, j, phi, more_phi) : GroupSums{};
    f[at] = grid.cycle.f[slot] + from_groups.one;
    more[at] = from_groups.other;
  }
  /// Returns the tile's entry of the k-th cell of a colour, row by row, `width / 2` per row.
  LICHTENBERG_HOST_DEVICE static int cell(int k, int colour) {
    const int y = k / (width / 2), x = 2 * (k % (width / 2)) + ((y + colour) & 1);
    return y * width + x;
  }
  /// Returns true if the tile's cell `at` is at least `edge` cells from the edge of the tile.
  LICHTENBERG_HOST_DEVICE static bool is_within(int at, int edge) {
    const int x = at % width, y = at / width;
    return x >= edge && x < width - edge && y >= edge && y < height - edge;
  }
};

/// Size of tiles in coarse cells: `across` columns and `along` rows. Small tiles finish sooner, large ones share fewer
/// cells.
template <int across_, int along_>
struct Tiling {
  static constexpr int across = across_, along = along_;
  /// Returns the number of tiles (rectangles of cells) side by side in the grid.
  LICHTENBERG_HOST_DEVICE static int in_a_row(const GridView& coarse) {
    return (coarse.layout.nx + across - 1) / across;
  }
  /// Returns the number of tiles (rectangles of cells) that cover the grid.
  static int all(const GridView& coarse) { return in_a_row(coarse) * ((coarse.layout.ny + along - 1) / along); }
};

/// Computes the restriction of red cells' residuals to coarse cell (I, J) by full weighting. `nx`, `ny`: size of the
/// coarse grid. The function red(x, y) returns the residual of a fine cell, x columns and y rows from the lower left
/// one in (I, J). Mirror images continue the residual beyond the box.
template <class Red>
LICHTENBERG_HOST_DEVICE float full_weighting(const ProblemView& problem, int nx, int ny, int I, int J, Red red) {
  const auto mirror = [&](int side) { return problem.electrode[side] ? -1.0f : 1.0f; };
  const float own_lower = J == 0 ? 0.75f + 0.25f * mirror(2) : 0.75f;
  const float own_upper = J == ny - 1 ? 0.75f + 0.25f * mirror(3) : 0.75f;
  const auto even = [&](int x) { return own_lower * red(x, 0) + 0.25f * red(x, 2); };
  const auto odd = [&](int x) { return 0.25f * red(x, -1) + own_upper * red(x, 1); };
  const float own_even = even(0), own_odd = odd(1);
  const float odd_before = I == 0 ? mirror(0) * own_even : odd(-1);
  const float even_behind = I == nx - 1 ? mirror(1) * own_odd : even(2);
  return 0.75f * (own_even + own_odd) + 0.25f * (odd_before + even_behind);
}

/// Kernel for the first half of a V-cycle on a tile (rectangle of cells). It relaxes red, then black cells from zero
/// with the potentials `phi` of groups (bodies with one potential). It stores the coarse right-hand side by full
/// weighting and, in v, the potentials of those cells that the groups' residuals need.
template <class V, class Tiles>
struct Descend {
  ProblemView problem;
  GridView fine, coarse;
  /// Potentials of the groups; null if no group has an unknown potential.
  const float* phi;
  V* v;

  static constexpr int halo = 3;
  using Cells = Tile<2 * Tiles::across + 2 * halo, 2 * Tiles::along + 2 * halo>;
  static std::size_t bytes(const GridView& fine) { return Cells::bytes(fine.has_medium); }

  template <class Block>
  LICHTENBERG_HOST_DEVICE void operator()(const Block& block, int b) const {
    const Cells tile(block.template memory<float>(), fine.has_medium);
    const int I = b % Tiles::in_a_row(coarse) * Tiles::across, J = b / Tiles::in_a_row(coarse) * Tiles::along;
    const int from_i = 2 * I - halo, from_j = 2 * J - halo;
    block.template each<4>(Cells::cells, [&](int at) {
      const int x = at % Cells::width, y = at / Cells::width;
      tile.load(fine, at, from_i + x, from_j + y, phi, nullptr);
      tile.value[at] = (x + y) & 1 ? 0.0f : tile.f[at] * tile.inverse[at];
    });
    block.each(Cells::cells / 2, [&](int k) {
      const int at = Cells::cell(k, 1);
      if (Cells::is_within(at, 1)) tile.value[at] = (tile.f[at] + tile.flux(at)) * tile.inverse[at];
    });
    block.each(Cells::cells / 2, [&](int k) {  // a red cell's residual is the flux from its black neighbours
      const int at = Cells::cell(k, 0);
      if (Cells::is_within(at, 2)) tile.f[at] = tile.inverse[at] > 0 ? tile.flux(at) : 0.0f;
      leave(tile, at, from_i, from_j);
      leave(tile, Cells::cell(k, 1), from_i, from_j);
    });
    block.each(Tiles::across * Tiles::along, [&](int k) {
      const int x = k % Tiles::across, y = k / Tiles::across;
      if (inside(coarse.layout, I + x, J + y))
        coarse.cycle.f[slot_of(coarse.layout, I + x, J + y)] =
            weighted(tile.f + (2 * y + halo) * Cells::width + 2 * x + halo, I + x, J + y);
    });
  }

 private:
  /// Stores the potential of a tile's cell in v if the groups' relaxation reads it.
  LICHTENBERG_HOST_DEVICE void leave(const Cells& tile, int at, int from_i, int from_j) const {
    if (!phi || !Cells::is_within(at, halo)) return;
    const int i = from_i + at % Cells::width, j = from_j + at / Cells::width;
    if (!inside(fine.layout, i, j)) return;
    const int slot = slot_of(fine.layout, i, j);
    if (fine.binds && is_eliminated(fine, slot)) {
      const bool is_red = slot < static_cast<int>(fine.layout.colour_size());
      v[slot] = (fine.cycle.f[slot] + (is_red ? 0.0f : tile.flux(at))) * tile.inverse[at];
    } else if (fine.has_medium || fine.cells.owner[slot].is_boundary_cell()) {
      v[slot] = tile.value[at];
    }
  }
  /// Returns the full weighting around coarse cell (I, J), whose lower left fine cell is `own`.
  LICHTENBERG_HOST_DEVICE float weighted(const float* own, int I, int J) const {
    return full_weighting(problem, coarse.layout.nx, coarse.layout.ny, I, J,
                          [&](int x, int y) { return own[y * Cells::width + x]; });
  }
};

/// Returns the potential of a coarse cell for bilinear interpolation; in a covered cell (inside a conductor) that of
/// the conductor.
LICHTENBERG_HOST_DEVICE inline float potential_at(const ProblemView& problem, const GridView& grid, int slot) {
  const CellOwner owner = grid.cells.owner[slot];
  return owner.is_fluid() ? grid.cycle.v[slot] : grid.cycle.phi[problem.group_of[owner.body()]];
}

/// Returns the potential of coarse cell (i, j) or, beyond the box, of its mirror image, with opposite sign at an
/// electrode.
LICHTENBERG_HOST_DEVICE inline float mirrored_potential(const ProblemView& problem, const GridView& grid, int i,
                                                        int j) {
  const MirroredCell cell = MirroredCell::of(grid.layout.nx, grid.layout.ny, i, j, problem.electrode);
  return cell.sign * potential_at(problem, grid, slot_of(grid.layout, cell.i, cell.j));
}

/// Computes the bilinear interpolation to a fine red cell from four coarse cells. `own`: potential of the coarse cell
/// that contains it; `beside`, `above`, `both`: potentials of the neighbours in x, in y and in both. The red cell lies
/// left and below in its coarse cell in even rows, right and above in odd rows.
LICHTENBERG_HOST_DEVICE inline float interpolated(float own, float beside, float above, float both) {
  return 0.75f * (0.75f * own + 0.25f * beside) + 0.25f * (0.75f * above + 0.25f * both);
}

/// Kernel for the second half of a V-cycle on a tile (rectangle of cells). It adds the coarse grid's correction, then
/// relaxes black and red cells. `phi`: the groups' potentials of the first half, to which those of the coarse grid are
/// added; null: none. A group is a set of bodies with one potential.
template <class V, class Tiles>
struct Ascend {
  ProblemView problem;
  GridView fine, coarse;
  const float* phi;
  V* v;

  static constexpr int halo = 2, coarse_width = Tiles::across + 4, coarse_cells = coarse_width * (Tiles::along + 4);
  using Cells = Tile<2 * Tiles::across + 2 * halo, 2 * Tiles::along + 2 * halo>;
  static std::size_t bytes(const GridView& fine) {
    return Cells::bytes(fine.has_medium) + coarse_cells * sizeof(float);
  }

  template <class Block>
  LICHTENBERG_HOST_DEVICE void operator()(const Block& block, int b) const {
    float* correction = block.template memory<float>();
    const Cells tile(correction + coarse_cells, fine.has_medium);
    const int I = b % Tiles::in_a_row(coarse) * Tiles::across, J = b / Tiles::in_a_row(coarse) * Tiles::along;
    const int from_i = 2 * I - halo, from_j = 2 * J - halo;
    block.template each<4>(coarse_cells + Cells::cells, [&](int k) {
      if (k < coarse_cells) {
        correction[k] = mirrored_potential(problem, coarse, I - 2 + k % coarse_width, J - 2 + k / coarse_width);
        return;
      }
      const int at = k - coarse_cells;
      tile.load(fine, at, from_i + at % Cells::width, from_j + at / Cells::width, phi,
                phi ? coarse.cycle.phi : nullptr);
    });
    block.each(Cells::cells / 2, [&](int k) {
      const int at = Cells::cell(k, 0), x = at % Cells::width, y = at / Cells::width, s = y & 1 ? 1 : -1;
      const float* own = correction + (1 + y / 2) * coarse_width + 1 + x / 2;
      tile.value[at] = tile.inverse[at] > 0
                           ? tile.f[at] * tile.inverse[at] +
                                 interpolated(own[0], own[s], own[s * coarse_width], own[s * coarse_width + s])
                           : 0.0f;
    });
    block.each(Cells::cells / 2, [&](int k) {
      const int at = Cells::cell(k, 1);
      if (Cells::is_within(at, 1)) tile.value[at] = (tile.f[at] + tile.more[at] + tile.flux(at)) * tile.inverse[at];
    });
    block.each(4 * Tiles::across * Tiles::along, [&](int k) {
      const int x = halo + k % (2 * Tiles::across), y = halo + k / (2 * Tiles::across), at = y * Cells::width + x;
      if (!inside(fine.layout, from_i + x, from_j + y)) return;
      const bool red = ((x + y) & 1) == 0;
      const int slot = slot_of(fine.layout, from_i + x, from_j + y);
      if (phi && fine.binds && is_eliminated(fine, slot))  // until groups have been relaxed (bound.hpp)
        v[slot] = (fine.cycle.f[slot] + tile.flux(at)) * tile.inverse[at];
      else
        v[slot] = red ? (tile.f[at] + tile.more[at] + tile.flux(at)) * tile.inverse[at] : tile.value[at];
    });
  }
};

}  // namespace lichtenberg::laplace::device
