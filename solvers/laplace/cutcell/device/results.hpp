#pragma once

// Charges, forces and energy, with the formulas of ../results.cpp; one sum per body and per part of a side.

#include "solvers/laplace/cutcell/device/operator.hpp"

namespace lichtenberg::laplace::device {

/// Charge of a body (C/m) and force on it (N/m), the sum over some or all of its links (conductances to cells or
/// conductors).
struct BodyResult {
  double charge = 0, force_x = 0, force_y = 0;
  LICHTENBERG_HOST_DEVICE BodyResult& operator+=(const BodyResult& other) {
    charge += other.charge;
    force_x += other.force_x;
    force_y += other.force_y;
    return *this;
  }
  /// Adds the force of one link (conductance): `stress` times the derivative of the conductance.
  LICHTENBERG_HOST_DEVICE void add_force(double stress, Vec2 gradient) {
    force_x += stress * gradient.x;
    force_y += stress * gradient.y;
  }
};

/// Charge of a part of an electrode side (C/m), and its contribution to the energy (J/m).
struct SideResult {
  double charge = 0, energy = 0;
  LICHTENBERG_HOST_DEVICE SideResult& operator+=(const SideResult& other) {
    charge += other.charge;
    energy += other.energy;
    return *this;
  }
};

/// Solved problem on the finest grid: cell potentials in units of `scale` (V), group potentials in V. A group is a set
/// of bodies with one potential.
struct SolvedView {
  ProblemView problem;
  GridView grid;
  const double* cell;
  double scale;
  const double* group_potential;

  /// Returns the potential (V) of the cell at the memory index `slot`.
  LICHTENBERG_HOST_DEVICE double potential(int slot) const { return scale * cell[slot]; }
  /// Returns the potential (V) of a body.
  LICHTENBERG_HOST_DEVICE double body_potential(int body) const { return group_potential[problem.group_of[body]]; }

  /// Returns the contributions of link m, the conductance of a body to a fluid cell, to the body's charge and force
  /// (virtual work).
  LICHTENBERG_HOST_DEVICE BodyResult link_result(int m) const {
    const LinkArrays& links = grid.links;
    const double eps = problem.permittivity, stress = 0.5 * eps / grid.h, own = potential(links.slot[m]);
    const double d = group_potential[links.group[m]] - own;
    BodyResult result;
    result.charge = eps * links.conductance[m] * d;
    result.add_force(stress * d * d, links.gradient[m]);
    if (const int partner = links.partner_group[m]; partner >= 0) {
      const double across = group_potential[partner] - own;
      result.add_force(stress * across * across, links.partner_gradient[m]);
    }
    return result;
  }

  /// Returns the contributions of a direct link (a gap conductance) to the charge of its own body and the force on it.
  /// The link leads to another body or an electrode side.
  LICHTENBERG_HOST_DEVICE BodyResult direct_link_result(const DirectLink& link) const {
    const double eps = problem.permittivity, stress = 0.5 * eps / grid.h;
    const double other = link.is_to_electrode() ? problem.side_potential[link.face()] : body_potential(link.other);
    const double d = body_potential(link.own) - other;
    BodyResult result;
    result.charge = eps * link.conductance * d;
    result.add_force(stress * d * d, link.gradient);
    return result;
  }

  /// Returns the charge of one cell face of an electrode side, and its contribution to the energy.
  LICHTENBERG_HOST_DEVICE SideResult face_result(int side, int face) const {
    const auto [i, j] = cell_at_face(grid.layout, side, face);
    const int slot = slot_of(grid.layout, i, j);
    const CellOwner owner = grid.cells.owner[slot];
    const double given = problem.side_potential[side * problem.faces + face];
    double conductance = 2, other = 0;
    if (owner.is_fluid()) {
      other = potential(slot);
    } else {
      const int body = owner.body();
      conductance = conductor_link(grid.bodies.outline[body], cell_centre(i, j), direction(side), 0.5, nullptr).value;
      other = body_potential(body);
    }
    const double flux = problem.permittivity * conductance * (given - other);
    return {flux, 0.5 * flux * given};
  }
};

/// Stores the cell and body potentials in units of `scale`, for the history of solutions.
template <class Executor>
void store_solution(const Executor& run, SolvedView solved, SolutionView solution) {
  for_each_entry(run, solved.grid, 0, [=] LICHTENBERG_HOST_DEVICE(int slot) {
    const CellOwner owner = solved.grid.cells.owner[slot];
    solution.cell[slot] = owner.is_fluid() ? solved.cell[slot] : solved.body_potential(owner.body()) / solved.scale;
  });
  exchange_ghosts(run, solved.grid, solution.cell, ghosts_of_product);
  run.for_each(solved.problem.bodies, [=] LICHTENBERG_HOST_DEVICE(int body) {
    solution.body[body] = solved.body_potential(body) / solved.scale;
  });
}

/// Computes the charge and force of each body as sum over its links to cells and its direct links (gap conductances).
/// `result`: by index of the body in the problem.
template <class Executor>
void sum_bodies(const Executor& run, SolvedView solved, BodyResult* result) {
  const ProblemView& problem = solved.problem;
  const GridView& grid = solved.grid;
  const auto count = [=] LICHTENBERG_HOST_DEVICE(int rank) {
    return grid.link_start(rank + 1) - grid.link_start(rank) + grid.direct.start[rank + 1] - grid.direct.start[rank];
  };
  sum_segments_of_ranks(
      run, grid, Segments<decltype(count)>{problem.bodies, count},
      [=] LICHTENBERG_HOST_DEVICE(int rank, int t) {
        const int links = grid.link_start(rank + 1) - grid.link_start(rank);
        if (t < links) return solved.link_result(grid.link_start(rank) + t);
        return solved.direct_link_result(grid.direct.link[grid.direct.start[rank] + t - links]);
      },
      [=] LICHTENBERG_HOST_DEVICE(int rank, int t) {
        const int first = grid.link_start(rank);
        return t < grid.link_start(rank + 1) - first ? grid.layout.owns(grid.links.slot[first + t])
                                                     : grid.layout.is_first();
      },
      [=] LICHTENBERG_HOST_DEVICE(int rank, BodyResult sum) { result[problem.body_at[rank]] = sum; });
}

/// Number of parts into which the sum over a side is divided.
constexpr int side_parts = 64;

/// Computes the charge of each electrode side, and its contribution to the energy. `result` [4 * side_parts]: partial
/// sums by side and by part of the side; 0 for insulating sides.
template <class Executor>
void sum_sides(const Executor& run, SolvedView solved, SideResult* result) {
  const Layout at = solved.grid.layout;
  const auto first = [at] LICHTENBERG_HOST_DEVICE(int segment, int next) {
    return (segment % side_parts + next) * faces_of(at, segment / side_parts) / side_parts;
  };
  const auto count = [=] LICHTENBERG_HOST_DEVICE(int segment) {
    return solved.problem.electrode[segment / side_parts] ? first(segment, 1) - first(segment, 0) : 0;
  };
  sum_segments_of_ranks(
      run, solved.grid, Segments<decltype(count)>{4 * side_parts, count},
      [=] LICHTENBERG_HOST_DEVICE(int segment, int t) {
        return solved.face_result(segment / side_parts, first(segment, 0) + t);
      },
      [=] LICHTENBERG_HOST_DEVICE(int segment, int t) {
        return at.own.contains(cell_at_face(at, segment / side_parts, first(segment, 0) + t).j);
      },
      [=] LICHTENBERG_HOST_DEVICE(int segment, SideResult sum) { result[segment] = sum; });
}

}  // namespace lichtenberg::laplace::device
