#pragma once

// The V-cycle of multigrid.cpp, an item a cell, a boundary cell, a piece of links or a group. V is the type of the
// potentials: double on the finest grid, whose potentials are the preconditioned residual itself, else float. The
// arithmetic is single precision throughout.
//
// On the way down red cells (colour 0) hold f / diagonal, which is computed where it is needed and never stored; so is
// the coarse correction on the way up, since black cells are relaxed first and red ones forget what they had.

#include "solvers/laplace/cutcell/device/discretize.hpp"

namespace lichtenberg::laplace::device {

/// Threads that share the sum over a piece or a group: most groups have a piece or two.
constexpr int group_lanes = 8;

template <class Executor>
void widen(const Executor& run, long n, const float* from, double* to) {
  run.for_each(n, [=] LICHTENBERG_HOST_DEVICE(int k) { to[k] = from[k]; });
}

template <class Executor>
void add(const Executor& run, long n, const float* increment, float* to) {
  run.for_each(n, [=] LICHTENBERG_HOST_DEVICE(int k) { to[k] += increment[k]; });
}

/// f or, behind the cells, the groups' charges from an entry of the residual; groups are the finest grid's first to be
/// relaxed.
struct TakeResidual {
  GridView grid;
  LICHTENBERG_HOST_DEVICE void operator()(int k, double r) const {
    const int cells = static_cast<int>(grid.layout.size());
    if (k < cells) {
      grid.f[k] = static_cast<float>(r);
    } else {
      grid.charge[k - cells] = static_cast<float>(r);
      grid.phi[k - cells] = grid.charge[k - cells] * grid.group_inverse_diagonal[k - cells];
    }
  }
};

template <class Executor>
void take_residual(const Executor& run, ProblemView problem, GridView grid, const double* r) {
  const TakeResidual take{grid};
  run.for_each(static_cast<long>(grid.layout.size()) + problem.groups,
               [=] LICHTENBERG_HOST_DEVICE(int k) { take(k, r[k]); });
}

template <class Executor>
void copy(const Executor& run, long n, const float* from, float* to) {
  run.for_each(n, [=] LICHTENBERG_HOST_DEVICE(int k) { to[k] = from[k]; });
}

/// phi_next = (flux + what direct links bring) / diagonal: a Jacobi sweep over groups that are coupled directly.
template <class Executor>
void relax_direct_links(const Executor& run, ProblemView problem, GridView grid, const float* flux, const float* phi,
                        float* phi_next) {
  run.template sum_segments<group_lanes>(
      problem.groups, [=] LICHTENBERG_HOST_DEVICE(int g) { return grid.direct_links_of(problem, g); },
      [=] LICHTENBERG_HOST_DEVICE(int g, int t) {
        const DirectLink& link = grid.direct_link[grid.first_direct_link(problem, g) + t];
        return link.is_to_electrode() ? 0.0f : static_cast<float>(link.conductance) * phi[problem.group_of[link.other]];
      },
      [=] LICHTENBERG_HOST_DEVICE(int g, float sum) {
        phi_next[g] = (flux[g] + sum) * grid.group_inverse_diagonal[g];
      });
}

/// Adds conductance times the groups' potentials to f in the boundary cells of the colours named.
template <class Executor>
void add_group_potentials(const Executor& run, GridView grid, const float* phi, bool red, bool black) {
  const int colour_size = static_cast<int>(grid.layout.colour_size());
  for_each_of(run, grid, Of::boundary, [=] LICHTENBERG_HOST_DEVICE(int k) {
    const int slot = grid.boundary_slot[k];
    if (slot < colour_size ? !red : !black) return;
    float sum = grid.f[slot];
    for (int side = 0; side < 4; ++side) {
      const int link = grid.boundary_link_of(k, side);
      if (link >= 0) sum += static_cast<float>(grid.conductance[link]) * phi[grid.link_group[link]];
    }
    grid.f[slot] = sum;
  });
}

/// Adds what thin conductors bring to f in all cells of the colours named.
template <class Executor>
void add_thin_conductor_potentials(const Executor& run, ProblemView problem, GridView grid, const float* phi, bool red,
                                   bool black) {
  const int colour_size = static_cast<int>(grid.layout.colour_size());
  sum_thin_conductors(
      run, problem, grid, [=] LICHTENBERG_HOST_DEVICE(int body, float c) { return c * phi[problem.group_of[body]]; },
      [=] LICHTENBERG_HOST_DEVICE(int slot, float sum) {
        if (slot < colour_size ? red : black) grid.f[slot] += sum;
      });
}

/// What a cell's neighbours bring: conductance times potential, value(slot, side).
template <class Value>
LICHTENBERG_HOST_DEVICE float neighbour_flux(const GridView& grid, int slot, const Neighbours& n, Value value) {
  if (!grid.medium) return value(n.west, 0) + value(n.east, 1) + value(n.south, 2) + value(n.north, 3);
  return grid.east[n.west] * value(n.west, 0) + grid.east[slot] * value(n.east, 1) +
         grid.north[n.south] * value(n.south, 2) + grid.north[slot] * value(n.north, 3);
}

/// Zero in what lies behind the last row of each colour.
template <class V>
LICHTENBERG_HOST_DEVICE void clear_end(const Layout& at, int colour, int row, int column, V* v) {
  if (row == 0 && column < Layout::pad) v[colour * at.colour_size() + (at.ny + 2) * at.stride + column] = 0;
}

/// Red then black, from zero; writes the black cells.
template <class V, class Executor>
void sweep_from_zero(const Executor& run, GridView grid, V* v) {
  run.for_each(grid.layout.ny + 2, static_cast<int>(grid.layout.stride),
               [=] LICHTENBERG_HOST_DEVICE(int row, int column) {
                 const Layout& at = grid.layout;
                 const int slot = static_cast<int>(at.colour_size()) + row * static_cast<int>(at.stride) + column;
                 const float inverse = grid.inverse_diagonal[slot];
                 float value = 0;
                 if (inverse > 0) {
                   const Neighbours n = neighbours(at, 1, row, column);
                   const auto red = [&](int s, int) { return grid.f[s] * grid.inverse_diagonal[s]; };
                   value = (grid.f[slot] + neighbour_flux(grid, slot, n, red)) * inverse;
                 }
                 v[slot] = value;
                 clear_end(at, 1, row, column, v);
               });
}

/// Where the red cells' residuals are kept: in place of their potentials, in single precision.
template <class V>
float* residual_of(V* v) {
  return reinterpret_cast<float*>(v);
}

/// After that a red cell's residual is what its black neighbours have brought, a black one's zero.
template <class V, class Executor>
void leave_residual(const Executor& run, GridView grid, const V* v, float* residual) {
  run.for_each(grid.layout.ny + 2, static_cast<int>(grid.layout.stride),
               [=] LICHTENBERG_HOST_DEVICE(int row, int column) {
                 const Layout& at = grid.layout;
                 const int slot = row * static_cast<int>(at.stride) + column;
                 float value = 0;
                 if (grid.inverse_diagonal[slot] > 0)
                   value = neighbour_flux(grid, slot, neighbours(at, 0, row, column),
                                          [&](int s, int) { return static_cast<float>(v[s]); });
                 residual[slot] = value;
               });
}

/// The coarse f by full weighting.
template <class Executor>
void restrict_residual(const Executor& run, ProblemView problem, GridView fine, GridView coarse,
                       const float* residual) {
  run.for_each(2 * (coarse.layout.ny + 2), static_cast<int>(coarse.layout.stride),
               [=] LICHTENBERG_HOST_DEVICE(int row, int column) {
                 const Layout& at = coarse.layout;
                 const int colour = row >= at.ny + 2;
                 const int J = row - colour * (at.ny + 2) - 1, k = column - Layout::pad;
                 const int I = 2 * k + Layout::parity(colour, J);
                 if (k < 0 || !inside(at, I, J)) return;
                 // Red cell number m of fine row 2 J + j.
                 const std::ptrdiff_t stride = fine.layout.stride, own = (2 * J + 1) * stride + Layout::pad;
                 const auto red = [&](int m, int j) { return residual[own + j * stride + m]; };
                 const auto mirror = [&](int side) { return problem.electrode[side] ? -1.0f : 1.0f; };
                 const float own_lower = J == 0 ? 0.75f + 0.25f * mirror(2) : 0.75f;
                 const float own_upper = J == at.ny - 1 ? 0.75f + 0.25f * mirror(3) : 0.75f;
                 const auto even = [&](int m) { return own_lower * red(m, 0) + 0.25f * red(m, 2); };
                 const auto odd = [&](int m) { return 0.25f * red(m, -1) + own_upper * red(m, 1); };
                 const float own_even = even(I), own_odd = odd(I);
                 const float odd_before = I == 0 ? mirror(0) * own_even : odd(I - 1);
                 const float even_behind = I == at.nx - 1 ? mirror(1) * own_odd : even(I + 1);
                 coarse.f[slot_of(at, I, J)] = 0.75f * (own_even + own_odd) + 0.25f * (odd_before + even_behind);
               });
}

/// Partial sums over links of conductance times potential, by piece. `from_zero`: red cells hold f / diagonal.
template <class V>
struct LinkFlux {
  GridView grid;
  const V* v;
  bool from_zero;
  LICHTENBERG_HOST_DEVICE float operator()(int link) const {
    const int slot = grid.link_slot[link];
    const bool red = slot < static_cast<int>(grid.layout.colour_size());
    const float value = from_zero && red ? grid.f[slot] * grid.inverse_diagonal[slot] : static_cast<float>(v[slot]);
    return static_cast<float>(grid.conductance[link]) * value;
  }
};

template <class V, class Executor>
void sum_pieces(const Executor& run, ProblemView problem, GridView grid, LinkFlux<V> flux) {
  run.template sum_segments<group_lanes>(
      grid.pieces,
      [=] LICHTENBERG_HOST_DEVICE(int piece) {
        return piece < grid.piece_start[problem.groups] ? grid.piece_end[piece] - grid.piece_begin[piece] : 0;
      },
      [=] LICHTENBERG_HOST_DEVICE(int piece, int t) { return flux(grid.piece_begin[piece] + t); },
      [=] LICHTENBERG_HOST_DEVICE(int piece, float sum) { grid.partial[piece] = sum; });
}

/// finish(g, what a group's links and direct links bring).
template <class Executor, class Finish>
void sum_groups(const Executor& run, ProblemView problem, GridView grid, const float* phi, Finish finish) {
  const bool direct_links = grid.may_have(Of::direct_links);
  run.template sum_segments<group_lanes>(
      problem.groups,
      [=] LICHTENBERG_HOST_DEVICE(int g) {
        if (!(grid.group_inverse_diagonal[g] > 0)) return 0;
        const int links = grid.piece_start[g + 1] - grid.piece_start[g];
        return direct_links ? links + grid.direct_links_of(problem, g) : links;
      },
      [=] LICHTENBERG_HOST_DEVICE(int g, int t) {
        const int links = grid.piece_start[g + 1] - grid.piece_start[g];
        if (t < links) return grid.partial[grid.piece_start[g] + t];
        const DirectLink& link = grid.direct_link[grid.first_direct_link(problem, g) + t - links];
        return link.is_to_electrode() ? 0.0f : static_cast<float>(link.conductance) * phi[problem.group_of[link.other]];
      },
      finish);
}

/// The residuals of the groups, and with what the coarse grid's covered cells have collected its groups' charges; the
/// coarse grid's conductors start from these.
template <class V, class Executor>
void restrict_groups(const Executor& run, ProblemView problem, GridView fine, GridView coarse, const V* v) {
  const LinkFlux<V> flux{fine, v, true};
  run.template sum_segments<group_lanes>(
      fine.pieces + coarse.pieces,
      [=] LICHTENBERG_HOST_DEVICE(int p) {
        const GridView& grid = p < fine.pieces ? fine : coarse;
        const int piece = p < fine.pieces ? p : p - fine.pieces;
        if (piece >= grid.piece_start[2 * problem.groups]) return 0;
        const bool of_links = piece < grid.piece_start[problem.groups];
        return of_links == (p < fine.pieces) ? grid.piece_end[piece] - grid.piece_begin[piece] : 0;
      },
      [=] LICHTENBERG_HOST_DEVICE(int p, int t) {
        if (p < fine.pieces) return flux(fine.piece_begin[p] + t);
        return coarse.f[coarse.covered_slot[coarse.piece_begin[p - fine.pieces] + t]];
      },
      [=] LICHTENBERG_HOST_DEVICE(int p, float sum) {
        if (p < fine.pieces)
          fine.partial[p] = sum;
        else
          coarse.partial[p - fine.pieces] = sum;
      });
  const bool direct_links = fine.may_have(Of::direct_links);
  run.template sum_segments<group_lanes>(
      problem.groups,
      [=] LICHTENBERG_HOST_DEVICE(int g) {
        if (!(fine.group_inverse_diagonal[g] > 0)) return 0;
        const int covered = problem.groups + g;
        const int links = fine.piece_start[g + 1] - fine.piece_start[g];
        const int own = direct_links ? fine.direct_links_of(problem, g) : 0;
        return links + coarse.piece_start[covered + 1] - coarse.piece_start[covered] + own;
      },
      [=] LICHTENBERG_HOST_DEVICE(int g, int t) {
        const int links = fine.piece_start[g + 1] - fine.piece_start[g];
        if (t < links) return fine.partial[fine.piece_start[g] + t];
        const int first = coarse.piece_start[problem.groups + g];
        const int covered = coarse.piece_start[problem.groups + g + 1] - first;
        if (t < links + covered) return coarse.partial[first + t - links];
        const DirectLink& link = fine.direct_link[fine.first_direct_link(problem, g) + t - links - covered];
        return link.is_to_electrode() ? 0.0f
                                      : static_cast<float>(link.conductance) * fine.phi[problem.group_of[link.other]];
      },
      [=] LICHTENBERG_HOST_DEVICE(int g, float sum) {
        const float inverse = fine.group_inverse_diagonal[g];
        const float charge = inverse > 0 ? fine.charge[g] + sum - fine.phi[g] / inverse : 0.0f;
        coarse.charge[g] = charge;
        coarse.phi[g] = charge * coarse.group_inverse_diagonal[g];
      });
}

/// The residuals of the groups, in `flux`: for those that the coarse grid absorbs.
template <class V, class Executor>
void leave_group_residual(const Executor& run, ProblemView problem, GridView grid, const V* v) {
  sum_pieces(run, problem, grid, LinkFlux<V>{grid, v, true});
  sum_groups(run, problem, grid, grid.phi, [=] LICHTENBERG_HOST_DEVICE(int g, float sum) {
    const float inverse = grid.group_inverse_diagonal[g];
    grid.flux[g] = inverse > 0 ? grid.charge[g] + sum - grid.phi[g] / inverse : 0.0f;
  });
}

/// The residual of a group that the coarse grid absorbs goes to the four cells around it.
template <class Executor>
void restrict_absorbed(const Executor& run, ProblemView problem, GridView grid, const float* residual) {
  gather<few_lanes>(
      run, grid, grid.absorbed_groups,
      [=] LICHTENBERG_HOST_DEVICE(int g, int slot) {
        return residual[g] * weight_in(grid.layout, grid.centre[g], problem.electrode, slot, true);
      },
      [=] LICHTENBERG_HOST_DEVICE(int slot, float sum) { grid.f[slot] += sum; });
}

/// An absorbed group's potential is that of the four cells around it.
template <class Executor>
void interpolate_absorbed(const Executor& run, ProblemView problem, GridView grid) {
  for_each_of(run, grid, Of::newly_absorbed, [=] LICHTENBERG_HOST_DEVICE(int m) {
    const int g = grid.absorbed_groups.item[m];
    const Interpolation around = interpolate(grid.layout, grid.centre[g], problem.electrode);
    float sum = 0;
    for (int k = 0; k < 4; ++k) sum += around.weight[k] * grid.v[around.cell[k]];
    grid.phi[g] = sum;
  });
}

/// v and phi of the coarsest grid's unknowns (a cell's slot, or -1 - group) from f and charge.
template <class Executor>
void multiply_inverse(const Executor& run, GridView grid, const int* unknown, const float* inverse, float* v) {
  const int* number = grid.number + Of::coarse_unknowns;
  run.template sum_segments<32>(
      grid.room[Of::coarse_unknowns], [=] LICHTENBERG_HOST_DEVICE(int a) { return a < *number ? *number : 0; },
      [=] LICHTENBERG_HOST_DEVICE(int a, int b) {
        const int name = unknown[b];
        return inverse[a * *number + b] * (name >= 0 ? grid.f[name] : grid.charge[-1 - name]);
      },
      [=] LICHTENBERG_HOST_DEVICE(int a, float sum) {
        if (a < *number) (unknown[a] >= 0 ? v[unknown[a]] : grid.phi[-1 - unknown[a]]) = sum;
      });
}

/// Covered cells take their group's potential: bilinear interpolation reads them.
template <class Executor>
void fill_covered(const Executor& run, GridView grid) {
  for_each_of(run, grid, Of::covered,
              [=] LICHTENBERG_HOST_DEVICE(int m) { grid.v[grid.covered_slot[m]] = grid.phi[grid.covered_group[m]]; });
}

/// The coarse potentials around coarse cell (I, J), beyond the box their mirror images.
struct CoarsePatch {
  const GridView& grid;
  const ProblemView& problem;
  int I, J;

  LICHTENBERG_HOST_DEVICE float operator()(int i, int j) const {
    const Layout& at = grid.layout;
    i += I;
    j += J;
    float sign = 1;
    if (!inside(at, i, j)) {
      if (i < 0 ? problem.electrode[0] : i >= at.nx && problem.electrode[1]) sign = -sign;
      if (j < 0 ? problem.electrode[2] : j >= at.ny && problem.electrode[3]) sign = -sign;
      i = i < 0 ? 0 : i < at.nx ? i : at.nx - 1;
      j = j < 0 ? 0 : j < at.ny ? j : at.ny - 1;
    }
    return sign * grid.v[slot_of(at, i, j)];
  }
};

/// Relaxes the black cells after the red ones have got the coarse correction, bilinearly interpolated. Red cells of
/// even rows lie left and below in their coarse cell, those of odd rows right and above, so that what an odd row's
/// black cell sees is what an even row's does, turned by half a turn: s = 1 and -1.
template <class V, class Executor>
void prolongate_and_relax_black(const Executor& run, ProblemView problem, GridView fine, GridView coarse, V* v) {
  run.for_each(fine.layout.ny + 2, static_cast<int>(fine.layout.stride),
               [=] LICHTENBERG_HOST_DEVICE(int row, int column) {
                 const Layout& at = fine.layout;
                 const int slot = static_cast<int>(at.colour_size()) + row * static_cast<int>(at.stride) + column;
                 const float inverse = fine.inverse_diagonal[slot];
                 float value = 0;
                 if (inverse > 0) {
                   const int j = row - 1, s = j & 1 ? 1 : -1;
                   const CoarsePatch patch{coarse, problem, column - Layout::pad, j >> 1};
                   const float own = patch(0, 0), ahead = patch(s, 0), behind = patch(-s, 0), up = patch(0, s),
                               up_ahead = patch(s, s), up_behind = patch(-s, s), down = patch(0, -s),
                               down_behind = patch(-s, -s);
                   const auto between = [](float a, float b, float c, float d) {
                     return 0.75f * (0.75f * a + 0.25f * b) + 0.25f * (0.75f * c + 0.25f * d);
                   };
                   const float red_ahead = between(own, ahead, up, up_ahead);
                   const float red_behind = between(behind, own, up_behind, up);
                   const float red_up = between(up, up_behind, own, behind);
                   const float red_down = between(own, behind, down, down_behind);
                   const Neighbours n = neighbours(at, 1, row, column);
                   const bool odd = s > 0;
                   const auto red = [&](int cell, int side) {
                     const float correction = side == 0   ? (odd ? red_behind : red_ahead)
                                              : side == 1 ? (odd ? red_ahead : red_behind)
                                              : side == 2 ? (odd ? red_down : red_up)
                                                          : (odd ? red_up : red_down);
                     const float own_inverse = fine.inverse_diagonal[cell];
                     return own_inverse > 0 ? fine.f[cell] * own_inverse + correction : 0.0f;
                   };
                   value = (fine.f[slot] + neighbour_flux(fine, slot, n, red)) * inverse;
                 }
                 v[slot] = value;
                 clear_end(at, 1, row, column, v);
               });
}

template <class V, class Executor>
void relax_red(const Executor& run, GridView grid, V* v) {
  run.for_each(grid.layout.ny + 2, static_cast<int>(grid.layout.stride),
               [=] LICHTENBERG_HOST_DEVICE(int row, int column) {
                 const Layout& at = grid.layout;
                 const int slot = row * static_cast<int>(at.stride) + column;
                 const float inverse = grid.inverse_diagonal[slot];
                 float value = 0;
                 if (inverse > 0) {
                   const Neighbours n = neighbours(at, 0, row, column);
                   const auto black = [&](int s, int) { return static_cast<float>(v[s]); };
                   value = (grid.f[slot] + neighbour_flux(grid, slot, n, black)) * inverse;
                 }
                 v[slot] = value;
                 clear_end(at, 0, row, column, v);
               });
}

/// flux: the groups' charges and what their cells bring; `phi`: their potentials from that, direct links left out.
template <class V, class Executor>
void relax_groups(const Executor& run, ProblemView problem, GridView grid, const V* v, float* phi) {
  sum_pieces(run, problem, grid, LinkFlux<V>{grid, v, false});
  run.template sum_segments<group_lanes>(
      problem.groups,
      [=] LICHTENBERG_HOST_DEVICE(int g) {
        return grid.group_inverse_diagonal[g] > 0 ? grid.piece_start[g + 1] - grid.piece_start[g] : 0;
      },
      [=] LICHTENBERG_HOST_DEVICE(int g, int t) { return grid.partial[grid.piece_start[g] + t]; },
      [=] LICHTENBERG_HOST_DEVICE(int g, float sum) {
        grid.flux[g] = grid.charge[g] + sum;
        phi[g] = grid.flux[g] * grid.group_inverse_diagonal[g];
      });
}

/// Adds conductance times the groups' potentials to f, in the cells of the colours named.
template <class Executor>
void add_potentials(const Executor& run, const ProblemView& problem, const GridView& grid, const float* phi, bool red,
                    bool black) {
  if (!grid.may_have(Of::unknown_groups)) return;
  add_group_potentials(run, grid, phi, red, black);
  if (grid.may_have(Of::floating_thin_conductors)) add_thin_conductor_potentials(run, problem, grid, phi, red, black);
}

/// A grid's part of the V-cycle on the way down: conductors, red, black, and what is left for the next coarser grid.
template <class V, class Executor>
void descend(const Executor& run, const ProblemView& problem, const GridView& grid, const GridView& coarse, V* v) {
  // Conductors first: a conductor's charge spreads into its potential before the cells see it.
  if (grid.may_have(Of::direct_links)) {
    relax_direct_links(run, problem, grid, grid.charge, grid.phi, grid.phi_next);
    copy(run, problem.groups, grid.phi_next, grid.phi);
  }
  add_potentials(run, problem, grid, grid.phi, true, true);
  sweep_from_zero(run, grid, v);
  leave_residual(run, grid, static_cast<const V*>(v), residual_of(v));
  restrict_residual(run, problem, grid, coarse, residual_of(v));
  if (coarse.may_have(Of::newly_absorbed)) {
    leave_group_residual(run, problem, grid, static_cast<const V*>(v));
    restrict_absorbed(run, problem, coarse, grid.flux);
  }
  if (coarse.may_have(Of::unknown_groups)) restrict_groups(run, problem, grid, coarse, static_cast<const V*>(v));
}

/// The mirror image of descend(): black, red, conductors.
template <class V, class Executor>
void ascend(const Executor& run, const ProblemView& problem, const GridView& grid, const GridView& coarse, V* v) {
  fill_covered(run, coarse);
  if (coarse.may_have(Of::newly_absorbed)) interpolate_absorbed(run, problem, coarse);
  add_potentials(run, problem, grid, coarse.phi, false, true);
  prolongate_and_relax_black(run, problem, grid, coarse, v);
  add_potentials(run, problem, grid, coarse.phi, true, false);
  relax_red(run, grid, v);
  if (!grid.may_have(Of::unknown_groups)) return;
  if (!grid.may_have(Of::direct_links)) return relax_groups(run, problem, grid, static_cast<const V*>(v), grid.phi);
  relax_groups(run, problem, grid, static_cast<const V*>(v), grid.phi_next);
  add(run, problem.groups, coarse.phi, grid.phi);
  relax_direct_links(run, problem, grid, grid.flux, grid.phi, grid.phi_next);
  relax_direct_links(run, problem, grid, grid.flux, grid.phi_next, grid.phi);
}

}  // namespace lichtenberg::laplace::device
