#include "solvers/laplace/cutcell/grid.hpp"

#include <algorithm>

#include "solvers/laplace/cutcell/wavefront.hpp"
#include "solvers/parallel/huge_pages.hpp"

namespace lichtenberg::laplace {

namespace {

/// What a row of cells of one colour gets from its neighbours, all faces having conductance 1. `west` points at the
/// neighbour on the left of the first cell; the one on its right follows it.
struct Neighbours {
  const float *west, *south, *north;
  float flux(int k) const { return west[k] + west[k + 1] + south[k] + north[k]; }
};

/// What such a row gets in a medium: each face's conductance stands at the cell on its left or below it.
struct NeighboursInMedium {
  Neighbours cell;
  const float *west, *east, *south, *north;
  float flux(int k) const {
    return west[k] * cell.west[k] + east[k] * cell.west[k + 1] + south[k] * cell.south[k] + north[k] * cell.north[k];
  }
};

/// 0 where there is no unknown. Divides in any case, so that all can be divided at once.
void invert_row(int n, const double* __restrict diagonal, float* __restrict inverse) {
  for (int k = 0; k < n; ++k) {
    const auto d = static_cast<float>(diagonal[k]);
    const float one_over = 1.0f / (d > 0 ? d : 1.0f);
    inverse[k] = d > 0 ? one_over : 0.0f;
  }
}

// Neighbours are of the other colour, so that no row that is written is read.

/// v = (f + flux from the neighbours) / diagonal
template <class Around>
void relax_row(int n, float* v, const float* f, const float* inverse_diagonal, Around around) {
#pragma GCC ivdep
  for (int k = 0; k < n; ++k) v[k] = (f[k] + around.flux(k)) * inverse_diagonal[k];
}

void relax_row_from_zero(int n, float* __restrict v, const float* __restrict f,
                         const float* __restrict inverse_diagonal) {
  for (int k = 0; k < n; ++k) v[k] = f[k] * inverse_diagonal[k];
}

/// After a sweep from zero over red and then black, a red cell's residual is what its black neighbours have brought.
template <class Around>
void red_residual_row(int n, float* r, const float* inverse_diagonal, Around around) {
#pragma GCC ivdep
  for (int k = 0; k < n; ++k) r[k] = inverse_diagonal[k] > 0 ? around.flux(k) : 0.0f;
}

/// r = f + flux from the neighbours - diagonal v; r may be f.
template <class Around>
void residual_row(int n, float* r, const float* f, const float* v, const float* inverse_diagonal, Around around) {
#pragma GCC ivdep
  for (int k = 0; k < n; ++k)
    r[k] = inverse_diagonal[k] > 0 ? f[k] + around.flux(k) - v[k] / inverse_diagonal[k] : 0.0f;
}

}  // namespace

Grid::Grid(const Layout& at, int sweeps, parallel::Team& team)
    : layout(at), sweeps_(sweeps), team_(&team), natural_stride_(at.nx + 2 * Layout::pad) {
  for (std::vector<float>* values : {&v, &f, &inverse_diagonal_}) parallel::resize_in_huge_pages(*values, at.size());
  parallel::resize_in_huge_pages(residual_, at.colour_size());
  parallel::resize_in_huge_pages(natural_, (at.ny + 2) * natural_stride_);
}

void Grid::build(const LaplaceProblem& problem, const Level& level, parallel::Team& team) {
  const std::size_t groups = problem.groups.size();
  for_each_row(team, layout, [&](int j) {
    for (int colour = 0; colour < 2; ++colour) {
      const std::ptrdiff_t row = layout.row(colour, j);
      invert_row(layout.row_length(colour, j), &level.diagonal[row], &inverse_diagonal_[row]);
      // The coarsest grid's solve sets unknowns only: cells that a grounded conductor covers now would keep what they
      // had.
      std::fill_n(&v[row], layout.row_length(colour, j), 0.0f);
    }
  });
  links_.build(problem, level, team);
  covered_cell_.assign(level.covered.begin(), level.covered.end());
  covered_start_ = level.covered_start;
  body_group_.clear();
  for (const Body& body : problem.bodies) body_group_.push_back(body.group);

  links_.leave_out(level, level.bound.link_of_level);
  std::vector<float> group_diagonal = group_diagonals(problem, level, links_, team);
  build_bound(level, group_diagonal);
  phi.assign(groups, 0.0f);
  charge.assign(groups, 0.0f);
  flux_.assign(groups, 0.0f);
  group_inverse_diagonal_.assign(groups, 0.0f);
  for (std::size_t g = 0; g < groups; ++g)
    if (group_diagonal[g] > 0) group_inverse_diagonal_[g] = 1.0f / group_diagonal[g];
  coupling_ = couple_groups(problem, level);
  choose_block(level, group_diagonal);
  east_ = level.faces.east;
  north_ = level.faces.north;
  newly_absorbed_.assign(level.absorbed.begin(), level.absorbed.begin() + level.newly_absorbed);
  for (int side = 0; side < 4; ++side) mirror[side] = problem.sides[side].kind == Side::Kind::electrode ? -1.0f : 1.0f;
}

/// Calls effect(first slot, number of cells, neighbours) for the row of a colour.
template <class Effect>
void Grid::with_neighbours(int colour, int j, const Effect& effect) const {
  const std::ptrdiff_t at = layout.row(colour, j), south = layout.row(1 - colour, j - 1);
  const std::ptrdiff_t west = layout.row(1 - colour, j) + Layout::parity(colour, j) - 1;
  const Neighbours cells{&v[west], &v[south], &v[layout.row(1 - colour, j + 1)]};
  if (east_.empty())
    effect(at, layout.row_length(colour, j), cells);
  else
    effect(at, layout.row_length(colour, j),
           NeighboursInMedium{cells, &east_[west], &east_[at], &north_[south], &north_[at]});
}

void Grid::relax(int colour, int j) {
  with_neighbours(colour, j, [&](std::ptrdiff_t at, int n, const auto& around) {
    relax_row(n, &v[at], &f[at], &inverse_diagonal_[at], around);
  });
}

void Grid::add_link_fluxes(int j, const std::vector<float>& potential) {
  links_.add_to_row(j, potential.data(), [&](std::int32_t cell, float flux) { f[cell] += flux; });
}

/// Conductors first: a conductor's charge spreads into its potential before the cells see it. Without that the sweep
/// smooths against a wrong boundary (26 iterations of CG in place of 12).
void Grid::smooth_from_zero() {
  std::fill(phi.begin(), phi.end(), 0.0f);
  std::fill(flux_.begin(), flux_.end(), 0.0f);
  start_bound();
  add_bound_fluxes(flux_);
  relax_groups(true);
  wavefront(*team_, layout, sweeps_ == 1 ? 3 : 2, [&](int stage, int j) {
    if (stage == 0) {
      add_link_fluxes(j, phi);
      const std::ptrdiff_t at = layout.row(0, j);
      relax_row_from_zero(layout.row_length(0, j), &v[at], &f[at], &inverse_diagonal_[at]);
    } else if (stage == 1) {
      relax(1, j);
      note_bound(1, j);
    } else {
      with_neighbours(0, j, [&](std::ptrdiff_t at, int n, const auto& around) {
        red_residual_row(n, &residual_[at], &inverse_diagonal_[at], around);
      });
    }
  });
  for (int sweep = 1; sweep < sweeps_; ++sweep) {
    relax_groups_again(true);
    wavefront(*team_, layout, sweep + 1 == sweeps_ ? 3 : 2, [&](int stage, int j) {
      if (stage == 0) add_link_fluxes(j, flux_);
      if (stage < 2) {
        relax(stage, j);
        note_bound(stage, j);
      } else {
        with_neighbours(0, j, [&](std::ptrdiff_t at, int n, const auto& around) {
          residual_row(n, &residual_[at], &f[at], &v[at], &inverse_diagonal_[at], around);
        });
        set_bound_residuals(j);
      }
    });
  }
}

/// Full weighting, the transpose of bilinear interpolation: a coarse cell collects its fine cells' residuals with
/// weights 1 3 3 1 / 4 in each direction (black residuals are zero). What falls outside the box is mirrored back.
void Grid::restrict_row(Grid& coarse, int J) const {
  const int NX = coarse.layout.nx, NY = coarse.layout.ny;
  thread_local std::vector<float> buffer;
  buffer.resize(3 * (NX + 2 * Layout::pad));
  float* even = buffer.data() + Layout::pad;
  float* odd = even + NX + 2 * Layout::pad;
  float* sum = odd + NX + 2 * Layout::pad;
  const float* below = &residual_[layout.row(0, 2 * J - 1)];
  const float* lower = &residual_[layout.row(0, 2 * J)];
  const float* upper = &residual_[layout.row(0, 2 * J + 1)];
  const float* above = &residual_[layout.row(0, 2 * J + 2)];
  const float own_lower = J == 0 ? 0.75f + 0.25f * mirror[bottom] : 0.75f;
  const float own_upper = J == NY - 1 ? 0.75f + 0.25f * mirror[top] : 0.75f;
  for (int I = 0; I < NX; ++I) even[I] = own_lower * lower[I] + 0.25f * above[I];
  for (int I = 0; I < NX; ++I) odd[I] = 0.25f * below[I] + own_upper * upper[I];
  odd[-1] = mirror[left] * even[0];
  even[NX] = mirror[right] * odd[NX - 1];
  for (int I = 0; I < NX; ++I) sum[I] = 0.75f * (even[I] + odd[I]) + 0.25f * (odd[I - 1] + even[I + 1]);
  for (int colour = 0; colour < 2; ++colour) {
    float* f_row = &coarse.f[coarse.layout.row(colour, J)];
    const int parity = Layout::parity(colour, J);
    for (int k = 0; k < coarse.layout.row_length(colour, J); ++k) f_row[k] = sum[2 * k + parity];
  }
}

/// sum += what cells and coupled groups bring to each group, its own potential's share taken off. Coupled groups were
/// in balance when they were relaxed: what has changed since is theirs.
void Grid::add_group_charges(std::vector<float>& sum) const {
  std::vector<float> of_coupled;
  if (is_coupled_) {
    of_coupled.assign(phi.size(), 0.0f);
    add_cell_fluxes(of_coupled);
  }
  add_cell_fluxes(sum);
  for (std::size_t g = 0; g < phi.size(); ++g) {
    for (int m = coupling_.start[g]; m < coupling_.start[g + 1]; ++m)
      sum[g] += coupling_.conductance[m] * phi[coupling_.other[m]];
    sum[g] = group_inverse_diagonal_[g] > 0 ? sum[g] - phi[g] / group_inverse_diagonal_[g] : 0.0f;
  }
  if (!is_coupled_) return;
  for (std::size_t k = 0; k < block_.size(); ++k) {
    const int g = block_[k];
    sum[g] = static_cast<float>(of_coupled[g] + flux_from_outside(g) - block_flux_[k]);
  }
}

void Grid::absorb_charges(std::span<const AbsorbedGroup> groups) {
  for (const AbsorbedGroup& group : groups) {
    for (int k = 0; k < 4; ++k) f[group.cell[k]] += group.weight[k] * charge[group.group];
    charge[group.group] = 0;
  }
}

/// A conductor is the same unknown on both grids, unless the coarse one absorbs it; the residuals of the coarse cells
/// that it covers are its as well.
void Grid::restrict_groups(Grid& coarse) {
  coarse.charge = charge;
  add_group_charges(coarse.charge);
  coarse.absorb_charges(coarse.newly_absorbed_);
  const int bodies = static_cast<int>(body_group_.size());
  for (int body = 0; body < bodies; ++body) {
    float sum = 0;
    for (int m = coarse.covered_start_[body]; m < coarse.covered_start_[body + 1]; ++m)
      sum += coarse.f[coarse.covered_cell_[m]];
    coarse.charge[body_group_[body]] += sum;
  }
}

void Grid::restrict_to(Grid& coarse) {
  for_each_row(*team_, coarse.layout, [&](int J) { restrict_row(coarse, J); });
  restrict_groups(coarse);
}

void Grid::spread(const std::vector<float>& potential, const std::array<float, 4>& mirrored) {
  const int bodies = static_cast<int>(body_group_.size()), chunks = bands(layout, *team_);
  team_->for_each(chunks, [&](int chunk) {
    for (int body = bodies * chunk / chunks; body < bodies * (chunk + 1) / chunks; ++body)
      for (int m = covered_start_[body]; m < covered_start_[body + 1]; ++m)
        v[covered_cell_[m]] = potential[body_group_[body]];
  });
  for (const AbsorbedGroup& group : newly_absorbed_) {
    phi[group.group] = 0;
    for (int k = 0; k < 4; ++k) phi[group.group] += group.weight[k] * v[group.cell[k]];
  }
  const auto write_row = [&](int j, int from, float sign) {
    float* row = &natural_[(j + 1) * natural_stride_ + Layout::pad];
    for (int colour = 0; colour < 2; ++colour) {
      const float* v_row = &v[layout.row(colour, from)];
      const int parity = Layout::parity(colour, from);
      for (int k = 0; k < layout.row_length(colour, from); ++k) row[2 * k + parity] = sign * v_row[k];
    }
    row[-1] = mirrored[left] * row[0];
    row[layout.nx] = mirrored[right] * row[layout.nx - 1];
  };
  for_each_row(*team_, layout, [&](int j) { write_row(j, j, 1.0f); });
  write_row(-1, 0, mirrored[bottom]);
  write_row(layout.ny, layout.ny - 1, mirrored[top]);
}

/// Calls effect(slot, value) for the bilinear interpolation from `coarse` to every cell of a row: 9 3 3 1 / 16 of the
/// four nearest coarse cells.
template <class Effect>
void Grid::interpolate_row(const Grid& coarse, int colour, int j, const Effect& effect) const {
  const int beside = Layout::parity(colour, j) == 0 ? -1 : 1;
  const float* own = coarse.natural_row(j / 2);
  const float* next = coarse.natural_row(j / 2 + (j % 2 == 0 ? -1 : 1));
  const std::ptrdiff_t at = layout.row(colour, j);
  const int n = layout.row_length(colour, j);
  for (int I = 0; I < n; ++I)
    effect(at + I,
           0.75f * (0.75f * own[I] + 0.25f * own[I + beside]) + 0.25f * (0.75f * next[I] + 0.25f * next[I + beside]));
}

/// The correction goes to the red cells only: the black ones are relaxed next and forget what they had.
void Grid::correct_and_smooth(const Grid& coarse, const double* r, double* row_product) {
  for (int sweep = 0; sweep < sweeps_; ++sweep) {
    const bool is_last = sweep + 1 == sweeps_;
    wavefront(*team_, layout, 3, [&](int stage, int j) {
      if (stage == 0) {
        add_link_fluxes(j, sweep == 0 ? coarse.phi : flux_);
        if (sweep == 0) add_correction(coarse, j);
      } else if (stage == 1) {
        relax(1, j);
        note_bound(1, j);
      } else {
        relax(0, j);
        note_bound(0, j);
        if (r && is_last) row_product[j] = row_dot_of_cells(r, j);
      }
    });
    if (sweep == 0)
      for (std::size_t g = 0; g < phi.size(); ++g) phi[g] += coarse.phi[g];
    relax_groups_again(false);
    follow_groups(sweep + 1 == sweeps_ ? r : nullptr, row_product);
  }
}

void Grid::add_correction(const Grid& coarse, int j) {
  float* __restrict to = v.data();
  const float* __restrict inverse_diagonal = inverse_diagonal_.data();
  interpolate_row(coarse, 0, j, [=](std::ptrdiff_t slot, float correction) {
    to[slot] = inverse_diagonal[slot] > 0 ? to[slot] + correction : 0.0f;
  });
}

double Grid::row_dot_of_cells(const double* r, int j) const {
  double product = 0;
  for (int colour = 0; colour < 2; ++colour) {
    const std::ptrdiff_t at = layout.row(colour, j);
    product += row_dot(layout.row_length(colour, j), r + at, v.data() + at);
  }
  return product;
}

void Grid::interpolate_from(const Grid& coarse) {
  for_each_row(*team_, layout, [&](int j) {
    float* __restrict to = v.data();
    const float* __restrict inverse_diagonal = inverse_diagonal_.data();
    for (int colour = 0; colour < 2; ++colour)
      interpolate_row(coarse, colour, j,
                      [=](std::ptrdiff_t slot, float value) { to[slot] = inverse_diagonal[slot] > 0 ? value : 0.0f; });
  });
  phi = coarse.phi;
}

void Grid::settle_coupled() {
  if (!is_coupled_) return;
  std::fill(flux_.begin(), flux_.end(), 0.0f);
  take_bound_as_relaxed();
  add_cell_fluxes(flux_);
  relax_block();
}

void Grid::form_residual() {
  settle_coupled();
  take_bound_as_relaxed();
  for_each_row(*team_, layout, [&](int j) {
    for (int colour = 0; colour < 2; ++colour)
      with_neighbours(colour, j, [&](std::ptrdiff_t at, int n, const auto& around) {
        residual_row(n, &f[at], &f[at], &v[at], &inverse_diagonal_[at], around);
      });
    add_link_fluxes(j, phi);
  });
  add_group_charges(charge);
}

}  // namespace lichtenberg::laplace
