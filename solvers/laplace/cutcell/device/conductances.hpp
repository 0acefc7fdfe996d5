#pragma once

// Conductances and diagonals of a grid; one item per link or cell.

#include "solvers/laplace/cutcell/device/homogenized.hpp"

namespace lichtenberg::laplace::device {

/// Computes the conductance of each link between a fluid cell and a conductor. On the finest grid also computes the
/// derivatives of the conductances with respect to the conductors' positions.
template <class Executor>
void make_links(const Executor& run, ProblemView problem, GridView grid) {
  for_each_item(run, grid, Items::links, [=] LICHTENBERG_HOST_DEVICE(int m) {
    const int slot = grid.links.slot[m];
    const LinkEnd end = grid.links.end[m];
    if (end.is_subgrid_conductor()) {
      grid.links.conductance[m] = grid.medium.absorbed_bodies.points[grid.medium.point[end.body()]].share[end.corner()];
      return;
    }
    const int body = end.body(), side = end.side();
    const CellIndex cell = cell_of(grid.layout, slot);
    const Vec2 p = cell_centre(cell.i, cell.j), to_body = direction(side), onward = direction(side ^ 1);
    const Outline& outline = grid.bodies.outline[body];
    Conductance c = fluid_link(outline, p, to_body, grid.formula);
    int partner = -1;
    Vec2 partner_gradient;
    const int bi = cell.i + step_i(side ^ 1), bj = cell.j + step_j(side ^ 1);
    const CellOwner behind = inside(grid.layout, bi, bj) ? grid.cells.owner[slot_of(grid.layout, bi, bj)] : CellOwner();
    if (!behind.is_fluid() && problem.group_of[behind.body()] != problem.group_of[body]) {
      const int other = behind.body();
      const Outline& beyond = grid.bodies.outline[other];
      Conductance back = fluid_link(beyond, p, onward, grid.formula);
      correct_for_opposed_surface(outline, p + to_body, onward, beyond, c);
      const OpposedSurfaceCorrection squeezed = correct_for_opposed_surface(beyond, p + onward, to_body, outline, back);
      if (squeezed.close) {
        partner = problem.group_of[other];
        partner_gradient = squeezed.partner_gradient;
      }
    }
    grid.links.conductance[m] = grid.has_medium ? c.value * grid.medium.permittivity[slot] : c.value;
    const int k = grid.cells.owner[slot].boundary_number();
    grid.boundary.link[side * grid.capacity[Items::boundary] + k] = m;
    grid.boundary.coupling[4 * k + side] = {static_cast<float>(grid.links.conductance[m]), grid.links.group[m]};
    if (!grid.finest) return;
    grid.links.gradient[m] = c.gradient;
    grid.links.partner_group[m] = partner;
    grid.links.partner_gradient[m] = partner_gradient;
  });
}

/// Computes the conductances of the faces between fluid cells (outside all bodies) on a grid with an effective medium.
/// Its conductances include small bodies without unknowns. They are stored with the left or lower cell.
template <class Executor>
void make_faces(const Executor& run, GridView grid) {
  run.for_each(grid.layout.ny, grid.layout.nx, [=] LICHTENBERG_HOST_DEVICE(int j, int i) {
    const Layout& at = grid.layout;
    const int slot = slot_of(at, i, j);
    const auto face = [&](int ni, int nj) {
      if (!inside(at, ni, nj) || !grid.cells.owner[slot].is_fluid() ||
          !grid.cells.owner[slot_of(at, ni, nj)].is_fluid())
        return 0.0f;
      return face_conductance(grid.medium.permittivity[slot], grid.medium.permittivity[slot_of(at, ni, nj)]);
    };
    grid.medium.east[slot] = face(i + 1, j);
    grid.medium.north[slot] = face(i, j + 1);
  });
}

/// Computes the face conductances and the matrix diagonals on a grid with an effective medium, whose conductances
/// include small bodies without unknowns. The diagonals are stored as 1 / (sum of conductances) of each cell, those of
/// boundary cells (fluid cells next to a conductor) also as sums.
template <class Executor>
void make_medium_diagonals(const Executor& run, ProblemView problem, GridView grid) {
  make_faces(run, grid);
  run.for_each(grid.layout.ny, grid.layout.nx, [=] LICHTENBERG_HOST_DEVICE(int j, int i) {
    const Layout& at = grid.layout;
    const int slot = slot_of(at, i, j);
    double sum = 0;
    const CellOwner owner = grid.cells.owner[slot];
    if (owner.is_fluid()) {
      const Neighbours n = neighbours(at, slot);
      sum = static_cast<double>(grid.medium.east[n.west]) + grid.medium.east[slot] + grid.medium.north[n.south] +
            grid.medium.north[slot];
      if (grid.may_have(Items::subgrid_conductors))
        sum += gathered(grid.layout, grid.medium.subgrid_conductors, i, j,
                        [](int, float conductance) { return conductance; });
      for (int side = 0; side < 4; ++side) {
        if (!inside(at, i + step_i(side), j + step_j(side)) && problem.electrode[side])
          sum += 2 * grid.medium.permittivity[slot];
        const int link = owner.is_boundary_cell() ? grid.boundary_link_of(owner.boundary_number(), side) : -1;
        if (link >= 0) sum += grid.links.conductance[link];
      }
      if (owner.is_boundary_cell()) grid.boundary.diagonal[owner.boundary_number()] = sum;
    }
    grid.cells.inverse_diagonal[slot] = sum > 0 ? static_cast<float>(1.0 / sum) : 0.0f;
  });
}

/// Returns the diagonal (sum of conductances) of a cell without links to conductors. Each neighbour contributes 1, an
/// electrode side half a cell away 2, an insulating side 0.
LICHTENBERG_HOST_DEVICE inline int diagonal_without_links(const ProblemView& problem, const Layout& at, int i, int j) {
  int sum = 4;
  if (i == 0) sum += problem.electrode[0] ? 1 : -1;
  if (i == at.nx - 1) sum += problem.electrode[1] ? 1 : -1;
  if (j == 0) sum += problem.electrode[2] ? 1 : -1;
  if (j == at.ny - 1) sum += problem.electrode[3] ? 1 : -1;
  return sum;
}

/// Computes the matrix diagonals. They are stored as 1 / (sum of conductances) of each cell, those of boundary cells
/// (fluid cells next to a conductor) also as sums.
template <class Executor>
void make_diagonals(const Executor& run, ProblemView problem, GridView grid) {
  if (grid.has_medium) {
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
      if (grid.cells.owner[slot].is_boundary_cell()) return;  // below
      const int sum = diagonal_without_links(problem, at, i, j);
      if (grid.cells.owner[slot].is_fluid() && sum > 0) inverse = 1.0f / static_cast<float>(sum);
    }
    grid.cells.inverse_diagonal[slot] = inverse;
  });
  for_each_item(run, grid, Items::boundary, [=] LICHTENBERG_HOST_DEVICE(int k) {
    const int slot = grid.boundary.slot[k];
    const CellIndex cell = cell_of(grid.layout, slot);
    double sum = 0;
    for (int side = 0; side < 4; ++side) {
      const int link = grid.boundary_link_of(k, side);
      if (link >= 0)
        sum += grid.links.conductance[link];
      else if (inside(grid.layout, cell.i + step_i(side), cell.j + step_j(side)))
        sum += 1;
      else if (problem.electrode[side])
        sum += 2;
    }
    grid.boundary.diagonal[k] = sum;
    grid.cells.inverse_diagonal[slot] = static_cast<float>(1.0 / sum);
  });
}

}  // namespace lichtenberg::laplace::device
