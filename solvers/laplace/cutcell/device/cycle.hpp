#pragma once

// The V-cycle of multigrid.cpp, an item a cell, a boundary cell, a piece of links or a group. V is the type of the
// potentials: double on the finest grid, whose potentials are the preconditioned residual itself, else float. The
// arithmetic is single precision throughout.
//
// On the way down red cells (colour 0) hold f / diagonal, which is computed where it is needed and never stored; so is
// the coarse correction on the way up, since black cells are relaxed first and red ones forget what they had.

#include "solvers/laplace/cutcell/device/grid.hpp"

namespace lichtenberg::laplace::device {

template <class Executor>
void widen(const Executor& run, long n, const float* from, double* to) {
  run.for_each(n, [=] LICHTENBERG_HOST_DEVICE(int k) { to[k] = from[k]; });
}

template <class Executor>
void add(const Executor& run, long n, const float* increment, float* to) {
  run.for_each(n, [=] LICHTENBERG_HOST_DEVICE(int k) { to[k] += increment[k]; });
}

/// f and the groups' charges from a residual; the finest grid's first half of the sweep over conductors.
template <class Executor>
void take_residual(const Executor& run, SceneView scene, GridView grid, const double* r) {
  const int cells = static_cast<int>(grid.layout.size());
  run.for_each(cells, [=] LICHTENBERG_HOST_DEVICE(int slot) { grid.f[slot] = static_cast<float>(r[slot]); });
  run.for_each(scene.groups, [=] LICHTENBERG_HOST_DEVICE(int g) {
    grid.charge[g] = static_cast<float>(r[cells + g]);
    grid.phi[g] = grid.charge[g] * grid.group_inverse_diagonal[g];
  });
}

/// phi_next = (flux + what contacts bring) / diagonal: a Jacobi sweep over groups that are coupled directly.
template <class Executor>
void relax_contacts(const Executor& run, SceneView scene, GridView grid, const float* flux, const float* phi,
                    float* phi_next) {
  run.sum_segments(
      scene.groups,
      [=] LICHTENBERG_HOST_DEVICE(int g) {
        return grid.contact_start[scene.first_rank[g + 1]] - grid.contact_start[scene.first_rank[g]];
      },
      [=] LICHTENBERG_HOST_DEVICE(int g, int t) {
        const Contact& contact = grid.contact[grid.contact_start[scene.first_rank[g]] + t];
        return contact.other < 0 ? 0.0f : static_cast<float>(contact.conductance) * phi[scene.group_of[contact.other]];
      },
      [=] LICHTENBERG_HOST_DEVICE(int g, float sum) {
        phi_next[g] = (flux[g] + sum) * grid.group_inverse_diagonal[g];
      });
}

/// Adds conductance times the groups' potentials to f in the boundary cells of the colours named.
template <class Executor>
void add_group_potentials(const Executor& run, GridView grid, const float* phi, bool red, bool black) {
  const int colour_size = static_cast<int>(grid.layout.colour_size());
  run.for_each(grid.boundary, [=] LICHTENBERG_HOST_DEVICE(int k) {
    const int slot = grid.boundary_slot[k];
    if (slot < colour_size ? !red : !black) return;
    float sum = grid.f[slot];
    for (int side = 0; side < 4; ++side) {
      const int link = grid.boundary_link[side * grid.boundary + k];
      if (link >= 0) sum += static_cast<float>(grid.conductance[link]) * phi[grid.link_group[link]];
    }
    grid.f[slot] = sum;
  });
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
                   const auto red = [&](int s) { return grid.f[s] * grid.inverse_diagonal[s]; };
                   value = (grid.f[slot] + red(n.west) + red(n.east) + red(n.south) + red(n.north)) * inverse;
                 }
                 v[slot] = value;
                 clear_end(at, 1, row, column, v);
               });
}

/// The coarse f: full weighting of the residuals, which are zero in black cells and what the black neighbours have
/// brought in red ones.
template <class V, class Executor>
void restrict_residual(const Executor& run, SceneView scene, GridView fine, GridView coarse, const V* v) {
  run.for_each(
      2 * (coarse.layout.ny + 2), static_cast<int>(coarse.layout.stride),
      [=] LICHTENBERG_HOST_DEVICE(int row, int column) {
        const Layout &at = coarse.layout, &from = fine.layout;
        const int colour = row >= at.ny + 2;
        const int J = row - colour * (at.ny + 2) - 1, k = column - Layout::pad;
        const int I = 2 * k + Layout::parity(colour, J);
        if (k < 0 || !inside(at, I, J)) return;
        const int stride = static_cast<int>(from.stride);
        // The residual of red cell number m of fine row j.
        const auto residual = [&](int m, int j) {
          const int slot = (j + 1) * stride + Layout::pad + m;
          if (!(fine.inverse_diagonal[slot] > 0)) return 0.0f;
          const Neighbours n = neighbours(from, 0, j + 1, Layout::pad + m);
          return static_cast<float>(v[n.west]) + static_cast<float>(v[n.east]) + static_cast<float>(v[n.south]) +
                 static_cast<float>(v[n.north]);
        };
        const auto mirror = [&](int side) { return scene.electrode[side] ? -1.0f : 1.0f; };
        const float own_lower = J == 0 ? 0.75f + 0.25f * mirror(2) : 0.75f;
        const float own_upper = J == at.ny - 1 ? 0.75f + 0.25f * mirror(3) : 0.75f;
        const auto even = [&](int m) { return own_lower * residual(m, 2 * J) + 0.25f * residual(m, 2 * J + 2); };
        const auto odd = [&](int m) { return 0.25f * residual(m, 2 * J - 1) + own_upper * residual(m, 2 * J + 1); };
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

/// The residuals of the groups, and with what the coarse grid's covered cells have collected its groups' charges; the
/// coarse grid's conductors start from these.
template <class V, class Executor>
void restrict_groups(const Executor& run, SceneView scene, GridView fine, GridView coarse, const V* v) {
  const LinkFlux<V> flux{fine, v, true};
  run.sum_segments(
      fine.pieces + coarse.pieces,
      [=] LICHTENBERG_HOST_DEVICE(int p) {
        const GridView& grid = p < fine.pieces ? fine : coarse;
        const int piece = p < fine.pieces ? p : p - fine.pieces;
        const bool of_links = piece < grid.piece_start[scene.groups];
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
  const bool contacts = fine.contacts > 0;
  run.sum_segments(
      scene.groups,
      [=] LICHTENBERG_HOST_DEVICE(int g) {
        const int covered = scene.groups + g;
        const int links = fine.piece_start[g + 1] - fine.piece_start[g];
        const int own =
            contacts ? fine.contact_start[scene.first_rank[g + 1]] - fine.contact_start[scene.first_rank[g]] : 0;
        return links + coarse.piece_start[covered + 1] - coarse.piece_start[covered] + own;
      },
      [=] LICHTENBERG_HOST_DEVICE(int g, int t) {
        const int links = fine.piece_start[g + 1] - fine.piece_start[g];
        if (t < links) return fine.partial[fine.piece_start[g] + t];
        const int first = coarse.piece_start[scene.groups + g];
        const int covered = coarse.piece_start[scene.groups + g + 1] - first;
        if (t < links + covered) return coarse.partial[first + t - links];
        const Contact& contact = fine.contact[fine.contact_start[scene.first_rank[g]] + t - links - covered];
        return contact.other < 0 ? 0.0f
                                 : static_cast<float>(contact.conductance) * fine.phi[scene.group_of[contact.other]];
      },
      [=] LICHTENBERG_HOST_DEVICE(int g, float sum) {
        const float inverse = fine.group_inverse_diagonal[g];
        const float charge = inverse > 0 ? fine.charge[g] + sum - fine.phi[g] / inverse : 0.0f;
        coarse.charge[g] = charge;
        coarse.phi[g] = charge * coarse.group_inverse_diagonal[g];
      });
}

/// Covered cells take their group's potential: bilinear interpolation reads them.
template <class Executor>
void fill_covered(const Executor& run, GridView grid, int covered) {
  run.for_each(covered,
               [=] LICHTENBERG_HOST_DEVICE(int m) { grid.v[grid.covered_slot[m]] = grid.phi[grid.covered_group[m]]; });
}

/// Relaxes the black cells after the red ones have got the coarse correction.
template <class V, class Executor>
void prolongate_and_relax_black(const Executor& run, SceneView scene, GridView fine, GridView coarse, V* v) {
  run.for_each(fine.layout.ny + 2, static_cast<int>(fine.layout.stride),
               [=] LICHTENBERG_HOST_DEVICE(int row, int column) {
                 const Layout &at = fine.layout, &below = coarse.layout;
                 const int slot = static_cast<int>(at.colour_size()) + row * static_cast<int>(at.stride) + column;
                 const float inverse = fine.inverse_diagonal[slot];
                 float value = 0;
                 if (inverse > 0) {
                   const auto mirror = [&](int side) { return scene.electrode[side] ? -1.0f : 1.0f; };
                   const auto coarse_value = [&](int I, int J) {
                     float sign = 1.0f;
                     if (I < 0) {
                       I = 0;
                       sign *= mirror(0);
                     }
                     if (I >= below.nx) {
                       I = below.nx - 1;
                       sign *= mirror(1);
                     }
                     if (J < 0) {
                       J = 0;
                       sign *= mirror(2);
                     }
                     if (J >= below.ny) {
                       J = below.ny - 1;
                       sign *= mirror(3);
                     }
                     return sign * coarse.v[slot_of(below, I, J)];
                   };
                   // Red cells of even rows lie left and below in their coarse cell, those of odd rows right and above.
                   const auto red = [&](int s, int I, int J, int step) {
                     if (!(fine.inverse_diagonal[s] > 0)) return 0.0f;
                     const float own = 0.75f * coarse_value(I, J) + 0.25f * coarse_value(I + step, J);
                     const float next = 0.75f * coarse_value(I, J + step) + 0.25f * coarse_value(I + step, J + step);
                     return fine.f[s] * fine.inverse_diagonal[s] + (0.75f * own + 0.25f * next);
                   };
                   const int j = row - 1, i = 2 * (column - Layout::pad) + Layout::parity(1, j);
                   const int I = i >> 1, J = j >> 1;
                   const Neighbours n = neighbours(at, 1, row, column);
                   float sum = fine.f[slot];
                   if (j & 1) {  // i even: west and east in an odd row, south and north in even ones
                     sum += red(n.west, I - 1, J, 1);
                     sum += red(n.east, I, J, 1);
                     sum += red(n.south, I, J, -1);
                     sum += red(n.north, I, J + 1, -1);
                   } else {
                     sum += red(n.west, I, J, -1);
                     sum += red(n.east, I + 1, J, -1);
                     sum += red(n.south, I, J - 1, 1);
                     sum += red(n.north, I, J, 1);
                   }
                   value = sum * inverse;
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
                   value = (grid.f[slot] + static_cast<float>(v[n.west]) + static_cast<float>(v[n.east]) +
                            static_cast<float>(v[n.south]) + static_cast<float>(v[n.north])) *
                           inverse;
                 }
                 v[slot] = value;
                 clear_end(at, 0, row, column, v);
               });
}

/// flux: the groups' charges and what their cells bring; phi: their potentials from that, contacts left out.
template <class V, class Executor>
void relax_groups(const Executor& run, SceneView scene, GridView grid, const V* v) {
  const LinkFlux<V> flux{grid, v, false};
  run.sum_segments(
      grid.pieces,
      [=] LICHTENBERG_HOST_DEVICE(int piece) {
        return piece < grid.piece_start[scene.groups] ? grid.piece_end[piece] - grid.piece_begin[piece] : 0;
      },
      [=] LICHTENBERG_HOST_DEVICE(int piece, int t) { return flux(grid.piece_begin[piece] + t); },
      [=] LICHTENBERG_HOST_DEVICE(int piece, float sum) { grid.partial[piece] = sum; });
  run.sum_segments(
      scene.groups, [=] LICHTENBERG_HOST_DEVICE(int g) { return grid.piece_start[g + 1] - grid.piece_start[g]; },
      [=] LICHTENBERG_HOST_DEVICE(int g, int t) { return grid.partial[grid.piece_start[g] + t]; },
      [=] LICHTENBERG_HOST_DEVICE(int g, float sum) {
        grid.flux[g] = grid.charge[g] + sum;
        grid.phi_next[g] = grid.flux[g] * grid.group_inverse_diagonal[g];
      });
}

}  // namespace lichtenberg::laplace::device
