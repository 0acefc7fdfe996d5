#pragma once

// Cells of a large grid in the V-cycle, one tile per block. Each half of a cycle is one kernel, which computes the
// cells that tiles share once per tile. The arithmetic is in single precision.
//
// In the first half, red cells (colour 0) contain f / diagonal. Black cells are relaxed, which leaves residuals in red
// cells only. In the second half, black cells are relaxed after the red cells have received the coarse correction; red
// cells are last. Fluxes from groups are computed where they are needed and never added to f.

#include <cmath>

#include "solvers/laplace/cutcell/device/homogenized.hpp"
#include "solvers/parallel/unroll.hpp"

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

/// Cells of a tile of the grid, with a border (halo) on all sides, in a block's memory. A row consists of pairs of a
/// red and a black cell, the cells 2 k and 2 k + 1 of the grid's row for pair k. They have equal numbers in the rows of
/// their colours (Layout), and a warp takes a row of pairs at a time. `halo`: rows of the border; the row below the
/// border is even. `medium`: the conductances of faces differ from 1.
template <int rows_, int halo_, bool medium>
struct Tile {
  static constexpr int rows = rows_, halo = halo_, pairs = 32, cells = 2 * rows * pairs;
  /// Size of a tile's memory (bytes).
  static constexpr std::size_t bytes = (medium ? 5 : 3) * cells * sizeof(float);
  /// By colour, row and pair (at()). `inverse`: 1 / diagonal, negative in boundary cells, 0 without unknown. `f`:
  /// right-hand sides with the fluxes from groups. `value`: potentials. `east`, `north`: conductances of faces.
  float *inverse, *f, *value, *east, *north;

  LICHTENBERG_HOST_DEVICE explicit Tile(float* memory)
      : inverse(memory),
        f(memory + cells),
        value(memory + 2 * cells),
        east(memory + 3 * cells),
        north(memory + 4 * cells) {}

  /// Returns the index of a cell in the tile's arrays.
  LICHTENBERG_HOST_DEVICE static int at(int colour, int y, int pair) { return (colour * rows + y) * pairs + pair; }
  /// Returns 0 if the cell of `colour` is the left one of its pair in row y, else 1.
  LICHTENBERG_HOST_DEVICE static int shift(int colour, int y) { return (colour + y + halo) & 1; }

  /// Returns the flux from the four neighbours to an inner cell of the tile.
  LICHTENBERG_HOST_DEVICE float flux(int colour, int y, int pair) const {
    const int own = at(colour, y, pair), beside = at(1 - colour, y, pair);
    const int to_west = beside - 1 + shift(colour, y), to_east = to_west + 1;
    const int south = beside - pairs, to_north = beside + pairs;
    if constexpr (!medium) return value[to_west] + value[to_east] + value[south] + value[to_north];
    return east[to_west] * value[to_west] + east[own] * value[to_east] + north[south] * value[south] +
           north[own] * value[to_north];
  }
  /// Returns the potential of a cell after its relaxation.
  LICHTENBERG_HOST_DEVICE float relaxed(int colour, int y, int pair) const {
    const int own = at(colour, y, pair);
    return (f[own] + flux(colour, y, pair)) * std::abs(inverse[own]);
  }
  /// Loads the data of the tile's pair in row y: pair number k of the grid's row j. The potentials become those of a
  /// relaxation from zero; beyond the box all is zero. `phi`: potentials of the groups (bodies with one potential);
  /// `more_phi`: potentials of which the fluxes belong to f, but not to the first potentials. Both may be null.
  LICHTENBERG_HOST_DEVICE void load(const GridView& grid, int y, int pair, int k, int j, const float* phi,
                                    const float* more_phi) const {
    const Layout& layout = grid.layout;
    const bool is_inside = k >= 0 && 2 * k < layout.nx && j >= 0 && j < layout.ny;
    const int red = is_inside ? static_cast<int>(layout.row(0, j)) + k : 0;
    const int black = is_inside ? red + static_cast<int>(layout.colour_size()) : 0;
    float inverse_of[2] = {}, f_of[2] = {};
    bool is_near[2] = {};
    if (is_inside)
      for (int colour = 0; colour < 2; ++colour) {
        const int slot = colour == 0 ? red : black;
        inverse_of[colour] = grid.cells.inverse_diagonal[slot];
        f_of[colour] = grid.cycle.f[slot];
        is_near[colour] = phi && grid.cells.owner[slot].is_boundary_cell();
      }
    for (int colour = 0; colour < 2; ++colour) {
      const int own = at(colour, y, pair), slot = colour == 0 ? red : black;
      inverse[own] = is_near[colour] ? -inverse_of[colour] : inverse_of[colour];
      f[own] = f_of[colour];
      value[own] = f_of[colour] * inverse_of[colour];
      if (!medium) continue;
      east[own] = is_inside ? grid.medium.east[slot] : 0.0f;
      north[own] = is_inside ? grid.medium.north[slot] : 0.0f;
    }
    const bool is_anywhere = is_inside && phi && grid.may_have(Items::floating_subgrid_conductors);
    if (!is_near[0] && !is_near[1] && !is_anywhere) return;
    LICHTENBERG_UNROLL(1)  // few cells, for which registers must not be reserved twice
    for (int colour = 0; colour < 2; ++colour) {
      const int own = at(colour, y, pair), slot = colour == 0 ? red : black;
      const GroupSums sums = group_sums(grid, slot, 2 * k + Layout::parity(colour, j), j, phi, more_phi);
      const float first = f[own] + sums.one;
      f[own] = first + sums.other;
      value[own] = first * std::abs(inverse[own]);
    }
  }
};

/// Size of tiles in coarse cells: `across` columns and `along` rows. Low tiles finish sooner, high ones share fewer
/// cells.
template <int across_, int along_>
struct Tiling {
  static constexpr int across = across_, along = along_;
  /// Returns the number of tiles (rectangles of cells) side by side in the grid.
  LICHTENBERG_HOST_DEVICE static int in_a_row(const GridView& coarse) {
    return (coarse.layout.nx + across - 1) / across;
  }
  /// Returns the number of tiles (rectangles of cells) that cover the own rows of the fine grid.
  static int all(const GridView& fine) {
    return (fine.layout.nx / 2 + across - 1) / across * ((fine.layout.own.count() / 2 + along - 1) / along);
  }
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
template <int rows, bool medium>
struct Descend {
  ProblemView problem;
  GridView fine, coarse;
  /// Potentials of the groups; null if no group has an unknown potential.
  const float* phi;

  /// Border of a tile: three rows, and two pairs of columns.
  static constexpr int halo = 3, halo_pairs = 2;
  using Cells = Tile<rows, halo, medium>;
  using Tiles = Tiling<Cells::pairs - 2 * halo_pairs, rows / 2 - halo>;
  static constexpr std::size_t bytes = Cells::bytes;

  template <class Block>
  LICHTENBERG_HOST_DEVICE void operator()(const Block& block, int b) const {
    const Cells tile(block.template memory<float>());
    const int I = b % Tiles::in_a_row(coarse) * Tiles::across;
    const int J = fine.layout.own.begin / 2 + b / Tiles::in_a_row(coarse) * Tiles::along;
    const int from_k = I - halo_pairs, from_j = 2 * J - halo;
    block.each(rows, Cells::pairs, [&](int y, int pair) {
      tile.load(fine, y, pair, from_k + pair, from_j + y, phi, nullptr);
      leave(tile, 0, y, pair, from_k + pair, from_j + y);
    });
    block.each(rows - 2, Cells::pairs, [&](int row, int pair) {
      const int y = row + 1;
      tile.value[Cells::at(1, y, pair)] = tile.relaxed(1, y, pair);
      leave(tile, 1, y, pair, from_k + pair, from_j + y);
    });
    block.each(rows - 4, Cells::pairs, [&](int row, int pair) {  // a red cell's residual is the flux from black cells
      const int y = row + 2, own = Cells::at(0, y, pair);
      tile.value[own] = tile.inverse[own] != 0 ? tile.flux(0, y, pair) : 0.0f;
    });
    block.each(Tiles::along, Tiles::across, [&](int y, int x) {
      if (!inside(coarse.layout, I + x, J + y)) return;
      const float* own = tile.value + Cells::at(0, 2 * y + halo, x + halo_pairs);
      coarse.cycle.f[slot_of(coarse.layout, I + x, J + y)] =
          full_weighting(problem, coarse.layout.nx, coarse.layout.ny, I + x, J + y,
                         [&](int i, int j) { return own[j * Cells::pairs + (i >> 1)]; });
    });
  }

 private:
  /// Stores the potential of a tile's cell in v if the groups' relaxation reads it. The cell belongs to pair k of the
  /// grid's row j.
  LICHTENBERG_HOST_DEVICE void leave(const Cells& tile, int colour, int y, int pair, int k, int j) const {
    if (!phi || y < halo || y >= rows - halo) return;
    if (pair < halo_pairs || pair >= Cells::pairs - halo_pairs) return;
    const int own = Cells::at(colour, y, pair);
    const bool is_near = tile.inverse[own] < 0;
    if (!is_near && !medium) return;
    if (!inside(fine.layout, 2 * k, j)) return;
    const int slot = static_cast<int>(fine.layout.row(colour, j)) + k;
    if (fine.binds && is_near && is_eliminated(fine, slot))
      fine.cycle.v[slot] =
          (fine.cycle.f[slot] + (colour == 0 ? 0.0f : tile.flux(colour, y, pair))) * std::abs(tile.inverse[own]);
    else
      fine.cycle.v[slot] = tile.value[own];
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
template <int rows, bool medium>
struct Ascend {
  ProblemView problem;
  GridView fine, coarse;
  const float* phi;

  /// Border of a tile: two rows, and a pair of columns.
  static constexpr int halo = 2;
  using Cells = Tile<rows, halo, medium>;
  using Tiles = Tiling<Cells::pairs - 2, rows / 2 - halo>;
  static constexpr int coarse_width = Cells::pairs + 2, coarse_cells = coarse_width * (rows / 2 + 2);
  static constexpr std::size_t bytes = Cells::bytes + coarse_cells * sizeof(float);

  template <class Block>
  LICHTENBERG_HOST_DEVICE void operator()(const Block& block, int b) const {
    float* correction = block.template memory<float>();
    const Cells tile(correction + coarse_cells);
    const int I = b % Tiles::in_a_row(coarse) * Tiles::across;
    const int J = fine.layout.own.begin / 2 + b / Tiles::in_a_row(coarse) * Tiles::along;
    const int from_k = I - 1, from_j = 2 * J - halo;
    block.template each<2>(coarse_cells, [&](int k) {
      correction[k] = mirrored_potential(problem, coarse, I - 2 + k % coarse_width, J - 2 + k / coarse_width);
    });
    block.each(rows, Cells::pairs, [&](int y, int pair) {
      tile.load(fine, y, pair, from_k + pair, from_j + y, phi, phi ? coarse.cycle.phi : nullptr);
      const int red = Cells::at(0, y, pair), s = Cells::shift(0, y) ? 1 : -1;
      const float* own = correction + (1 + y / 2) * coarse_width + 1 + pair;
      if (tile.inverse[red] != 0)
        tile.value[red] += interpolated(own[0], own[s], own[s * coarse_width], own[s * coarse_width + s]);
    });
    block.each(rows - 2, Cells::pairs,
               [&](int row, int pair) { tile.value[Cells::at(1, row + 1, pair)] = tile.relaxed(1, row + 1, pair); });
    block.each(2 * Tiles::along, Tiles::across, [&](int row, int column) {
      const int y = row + halo, pair = column + 1, k = from_k + pair, j = from_j + y;
      if (!inside(fine.layout, 2 * k, j)) return;
      for (int colour = 0; colour < 2; ++colour) {
        const int own = Cells::at(colour, y, pair), slot = static_cast<int>(fine.layout.row(colour, j)) + k;
        if (fine.binds && tile.inverse[own] < 0 && is_eliminated(fine, slot))  // until groups are relaxed (bound.hpp)
          fine.cycle.v[slot] = (fine.cycle.f[slot] + tile.flux(colour, y, pair)) * std::abs(tile.inverse[own]);
        else
          fine.cycle.v[slot] = colour == 0 ? tile.relaxed(0, y, pair) : tile.value[own];
      }
    });
  }
};

}  // namespace lichtenberg::laplace::device
