#include "solvers/laplace/cutcell/grid.hpp"

#include <algorithm>

#include "solvers/laplace/cutcell/wavefront.hpp"
#include "solvers/parallel/huge_pages.hpp"

namespace lichtenberg::laplace {

namespace {

/// Flux into a row of cells of one colour from their neighbours through faces of conductance 1. `west` points to the
/// left neighbour of the first cell; its right neighbour follows.
struct Neighbours {
  const float *west, *south, *north;
  float flux(int k) const { return west[k] + west[k + 1] + south[k] + north[k]; }
};

/// Flux into a row of cells of one colour from their neighbours, through faces of varying conductance. The conductance
/// of a face is stored with the cell on its left or below it.
struct NeighboursInMedium {
  Neighbours cell;
  const float *west, *east, *south, *north;
  float flux(int k) const {
    return west[k] * cell.west[k] + east[k] * cell.west[k + 1] + south[k] * cell.south[k] + north[k] * cell.north[k];
  }
};

/// Computes the inverse of a row of the matrix diagonal, 0 where there is no unknown. An unconditional division permits
/// vectorization.
void invert_row(int n, const double* __restrict diagonal, float* __restrict inverse) {
  for (int k = 0; k < n; ++k) {
    const auto d = static_cast<float>(diagonal[k]);
    const float one_over = 1.0f / (d > 0 ? d : 1.0f);
    inverse[k] = d > 0 ? one_over : 0.0f;
  }
}

// Neighbours have the other colour, so that no row is both read and written.

/// Relaxes a row of cells of one colour: v = (f + flux from the neighbours) / diagonal.
template <class Around>
void relax_row(int n, float* v, const float* f, const float* inverse_diagonal, Around around) {
#pragma GCC ivdep
  for (int k = 0; k < n; ++k) v[k] = (f[k] + around.flux(k)) * inverse_diagonal[k];
}

void relax_row_from_zero(int n, float* __restrict v, const float* __restrict f,
                         const float* __restrict inverse_diagonal) {
  for (int k = 0; k < n; ++k) v[k] = f[k] * inverse_diagonal[k];
}

/// Computes the residual of red cells after a sweep from zero over red, then black cells. It is the flux from their
/// black neighbours.
template <class Around>
void red_residual_row(int n, float* r, const float* inverse_diagonal, Around around) {
#pragma GCC ivdep
  for (int k = 0; k < n; ++k) r[k] = inverse_diagonal[k] > 0 ? around.flux(k) : 0.0f;
}

/// Computes the residual r = f + flux from the neighbours - diagonal v of a row. r and f may be the same.
template <class Around>
void residual_row(int n, float* r, const float* f, const float* v, const float* inverse_diagonal, Around around) {
#pragma GCC ivdep
  for (int k = 0; k < n; ++k)
    r[k] = inverse_diagonal[k] > 0 ? f[k] + around.flux(k) - v[k] / inverse_diagonal[k] : 0.0f;
}

}  // namespace

Grid::Grid(const Layout& at, int sweeps, parallel::Team& team)
    : layout(at), sweeps_(sweeps), team_(&team), mirrored_(at) {
  for (std::vector<float>* values : {&v, &f, &inverse_diagonal_}) parallel::resize_in_huge_pages(*values, at.size());
  parallel::resize_in_huge_pages(residual_, at.colour_size());
}

void Grid::build(const LaplaceProblem& problem, const Level& level, parallel::Team& team) {
  const std::size_t groups = problem.groups.size();
  for_each_row(team, layout, layout.stored, [&](int j) {
    for (int colour = 0; colour < 2; ++colour) {
      const std::ptrdiff_t row = layout.row(colour, j);
      invert_row(layout.row_length(colour, j), &level.diagonal[row], &inverse_diagonal_[row]);
      // The coarsest grid's solve sets unknowns only; cells that a grounded conductor covers must be reset here.
      std::fill_n(&v[row], layout.row_length(colour, j), 0.0f);
    }
  });
  links_.build(problem, level, team);
  covered_.build(problem, level);
  links_.leave_out(level, level.eliminated.link_of_level);
  std::vector<float> group_diagonal = group_diagonals(problem, level, links_, team);
  eliminated_.build(level.eliminated, layout, group_diagonal);
  groups_.build(problem, level, group_diagonal);
  phi.assign(groups, 0.0f);
  charge.assign(groups, 0.0f);
  flux_.assign(groups, 0.0f);
  faces_ = level.faces;
  newly_absorbed_.assign(level.absorbed.begin(), level.absorbed.begin() + level.newly_absorbed);
  for (int side = 0; side < 4; ++side) mirror[side] = problem.sides[side].kind == Side::Kind::electrode ? -1.0f : 1.0f;
}

/// Calls effect(first slot, number of cells, neighbours) for the cells of a colour in row j. A slot is the memory index
/// of a cell.
template <class Effect>
void Grid::with_neighbours(int colour, int j, const Effect& effect) const {
  const std::ptrdiff_t at = layout.row(colour, j), south = layout.row(1 - colour, j - 1);
  const std::ptrdiff_t west = layout.row(1 - colour, j) + Layout::parity(colour, j) - 1;
  const Neighbours cells{&v[west], &v[south], &v[layout.row(1 - colour, j + 1)]};
  if (faces_.are_uniform())
    effect(at, layout.row_length(colour, j), cells);
  else
    effect(at, layout.row_length(colour, j),
           NeighboursInMedium{cells, &faces_.east[west], &faces_.east[at], &faces_.north[south], &faces_.north[at]});
}

void Grid::relax(int colour, int j) {
  with_neighbours(colour, j, [&](std::ptrdiff_t at, int n, const auto& around) {
    relax_row(n, &v[at], &f[at], &inverse_diagonal_[at], around);
  });
}

float Grid::flux_from_neighbours(const EliminatedCells::Cell& cell) const {
  const int colour = cell.slot < layout.colour_size() ? 0 : 1;
  const std::ptrdiff_t number = cell.slot - layout.row(colour, cell.row);
  const std::ptrdiff_t west = layout.row(1 - colour, cell.row) + Layout::parity(colour, cell.row) - 1 + number;
  const std::ptrdiff_t south = layout.row(1 - colour, cell.row - 1) + number;
  const std::ptrdiff_t north = layout.row(1 - colour, cell.row + 1) + number;
  if (faces_.are_uniform()) return v[west] + v[west + 1] + v[south] + v[north];
  return faces_.east[west] * v[west] + faces_.east[cell.slot] * v[west + 1] + faces_.north[south] * v[south] +
         faces_.north[cell.slot] * v[north];
}

/// Updates the fluxes into the eliminated cells of a row, after each relaxation of its cells of a colour.
void Grid::update_eliminated(int colour, int j) {
  eliminated_.update(colour, j, [this](const EliminatedCells::Cell& cell) { return flux_from_neighbours(cell); });
}

/// Adds the fluxes from cells to their groups (bodies with one potential) to `sum`, in all processes. Fluxes from
/// eliminated near-surface cells do not contain the part that returns to them.
void Grid::add_cell_fluxes(std::vector<float>& sum) const {
  add_sums(layout, std::ssize(sum), sum.data(), [this](float* part) {
    links_.add_to_groups(*team_, v.data(), part);
    eliminated_.add_fluxes(part);
  });
}

/// Relaxes the groups (bodies with one potential) after a sweep over cells. Sets flux_ to the change of their
/// potentials.
void Grid::relax_groups_again(bool forward) {
  const std::vector<float> before = phi;
  std::fill(flux_.begin(), flux_.end(), 0.0f);
  if (forward)
    for (int j = layout.own.begin; j < layout.own.end; ++j) update_eliminated(0, j);
  add_cell_fluxes(flux_);
  groups_.relax(forward, charge, flux_, phi);
  for (std::size_t g = 0; g < phi.size(); ++g) flux_[g] = phi[g] - before[g];
}

void Grid::add_link_fluxes(int j, const std::vector<float>& potential) {
  links_.add_to_row(j, potential.data(), [&](std::int32_t cell, float flux) { f[cell] += flux; });
}

/// Returns the number of ghost rows whose red cells a sweep before the correction relaxes. The last sweep leaves them
/// correct in the rows that the sweeps after the correction start from, and the residual in one ghost row.
int Grid::ghosts_before(int sweep) const { return std::max(2 * sweeps_, 3) + 2 * (sweeps_ - 1 - sweep); }

/// Relaxes conductors first, so that the sweep over cells has their potentials as boundary values. CG then needs 12
/// iterations, otherwise 26.
void Grid::smooth_from_zero() {
  exchange_ghosts(layout, f.data(), ghosts_before(0));
  std::fill(phi.begin(), phi.end(), 0.0f);
  std::fill(flux_.begin(), flux_.end(), 0.0f);
  eliminated_.start(f);
  add_sums(layout, std::ssize(flux_), flux_.data(), [this](float* part) { eliminated_.add_fluxes(part); });
  groups_.relax(true, charge, flux_, phi);
  const auto stages = [this](int sweep) { return sweep + 1 == sweeps_ ? 3 : 2; };
  wavefront(*team_, layout, stages(0), ghosts_before(0) + 1 - stages(0), [&](int stage, int j) {
    if (stage == 0) {
      add_link_fluxes(j, phi);
      const std::ptrdiff_t at = layout.row(0, j);
      relax_row_from_zero(layout.row_length(0, j), &v[at], &f[at], &inverse_diagonal_[at]);
    } else if (stage == 1) {
      relax(1, j);
      update_eliminated(1, j);
    } else {
      with_neighbours(0, j, [&](std::ptrdiff_t at, int n, const auto& around) {
        red_residual_row(n, &residual_[at], &inverse_diagonal_[at], around);
      });
    }
  });
  for (int sweep = 1; sweep < sweeps_; ++sweep) {
    relax_groups_again(true);
    wavefront(*team_, layout, stages(sweep), ghosts_before(sweep) + 1 - stages(sweep), [&](int stage, int j) {
      if (stage == 0) add_link_fluxes(j, flux_);
      if (stage < 2) {
        relax(stage, j);
        update_eliminated(stage, j);
      } else {
        with_neighbours(0, j, [&](std::ptrdiff_t at, int n, const auto& around) {
          residual_row(n, &residual_[at], &f[at], &v[at], &inverse_diagonal_[at], around);
        });
        eliminated_.set_red_residuals(
            j, [this](const EliminatedCells::Cell& cell) { return flux_from_neighbours(cell); }, residual_);
      }
    });
  }
}

/// Restricts the residual to row J of the coarse grid by full weighting, the transpose of bilinear interpolation. The
/// weights are 1 3 3 1 / 4 of the fine cells' residuals in each direction (black residuals are zero). Contributions to
/// cells outside the box are mirrored.
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

/// Adds fluxes to the groups' charges such that these become the residuals of the groups' equations.
void Grid::add_group_residuals(std::vector<float>& charges) const {
  std::vector<float> flux;
  if (groups_.is_coupled()) {
    flux.assign(phi.size(), 0.0f);
    add_cell_fluxes(flux);
  }
  add_cell_fluxes(charges);
  groups_.complete_residuals(phi, flux, charges);
}

void Grid::absorb_charges(std::span<const AbsorbedGroup> groups) {
  // In a slab, cells of other processes have the weight 0.
  for (const AbsorbedGroup& group : groups) {
    for (int k = 0; k < 4; ++k) f[group.cell[k]] += group.weight[k] * charge[group.group];
    charge[group.group] = 0;
  }
}

/// Restricts the groups' residuals. A group has an unknown on both grids, unless the coarse one absorbs it. It also
/// receives the residuals of the coarse cells that its bodies cover.
void Grid::restrict_groups(Grid& coarse) {
  coarse.charge = charge;
  add_group_residuals(coarse.charge);
  coarse.absorb_charges(coarse.newly_absorbed_);
  add_sums(coarse.layout, std::ssize(coarse.charge), coarse.charge.data(),
           [&coarse](float* part) { coarse.covered_.add_to_groups(coarse.f, part); });
}

void Grid::restrict_to(Grid& coarse) {
  const Rows rows{layout.own.begin / 2, layout.own.end / 2};
  for_each_row(*team_, coarse.layout, rows, [&](int J) { restrict_row(coarse, J); });
  if (!coarse.layout.is_divided()) gather_rows(coarse.layout, rows, coarse.f.data());
  restrict_groups(coarse);
}

void Grid::spread(const std::vector<float>& potential, const std::array<float, 4>& mirrored) {
  covered_.fill(potential, *team_, bands(layout, layout.own, *team_), v);
  exchange_ghosts(layout, v.data(), MirroredRows::ghosts);
  std::vector<float> absorbed(newly_absorbed_.size(), 0.0f);
  for (std::size_t n = 0; n < absorbed.size(); ++n)
    for (int k = 0; k < 4; ++k) absorbed[n] += newly_absorbed_[n].weight[k] * v[newly_absorbed_[n].cell[k]];
  add_over_slabs(layout, absorbed.data(), std::ssize(absorbed));
  for (std::size_t n = 0; n < absorbed.size(); ++n) phi[newly_absorbed_[n].group] = absorbed[n];
  mirrored_.assign(v, mirrored, layout, *team_);
}

/// Calls effect(slot, value) for every cell of a colour in row j, with the bilinear interpolation from `coarse`. The
/// weights are 9 3 3 1 / 16 of the four nearest coarse cells. A slot is the memory index of a cell.
template <class Effect>
void Grid::interpolate_row(const Grid& coarse, int colour, int j, const Effect& effect) const {
  const int next_column = Layout::parity(colour, j) == 0 ? -1 : 1;
  const float* own = coarse.mirrored_.row(j / 2);
  const float* next = coarse.mirrored_.row(j / 2 + (j % 2 == 0 ? -1 : 1));
  const std::ptrdiff_t at = layout.row(colour, j);
  const int n = layout.row_length(colour, j);
  for (int I = 0; I < n; ++I)
    effect(at + I, 0.75f * (0.75f * own[I] + 0.25f * own[I + next_column]) +
                       0.25f * (0.75f * next[I] + 0.25f * next[I + next_column]));
}

/// Adds the correction to red cells only, because the subsequent relaxation of black cells overwrites their values.
void Grid::correct_and_smooth(const Grid& coarse, const double* r, double* row_product) {
  for (int sweep = 0; sweep < sweeps_; ++sweep) {
    const bool is_last = sweep + 1 == sweeps_;
    wavefront(*team_, layout, 3, 2 * (sweeps_ - 1 - sweep), [&](int stage, int j) {
      if (stage == 0) {
        add_link_fluxes(j, sweep == 0 ? coarse.phi : flux_);
        if (sweep == 0) add_correction(coarse, j);
      } else if (stage == 1) {
        relax(1, j);
        update_eliminated(1, j);
      } else {
        relax(0, j);
        update_eliminated(0, j);
        if (r && is_last) row_product[j] = row_dot_of_cells(r, j);
      }
    });
    if (sweep == 0)
      for (std::size_t g = 0; g < phi.size(); ++g) phi[g] += coarse.phi[g];
    relax_groups_again(false);
    eliminated_.substitute(phi, is_last ? r : nullptr, row_product, v);
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
  for_each_row(*team_, layout, layout.extended(1), [&](int j) {
    float* __restrict to = v.data();
    const float* __restrict inverse_diagonal = inverse_diagonal_.data();
    for (int colour = 0; colour < 2; ++colour)
      interpolate_row(coarse, colour, j,
                      [=](std::ptrdiff_t slot, float value) { to[slot] = inverse_diagonal[slot] > 0 ? value : 0.0f; });
  });
  phi = coarse.phi;
}

void Grid::solve_coupled_groups() {
  if (!groups_.is_coupled()) return;
  std::fill(flux_.begin(), flux_.end(), 0.0f);
  eliminated_.set_relaxed(v, phi);
  add_cell_fluxes(flux_);
  groups_.relax_block(charge, flux_, phi);
}

void Grid::form_residual() {
  solve_coupled_groups();
  eliminated_.set_relaxed(v, phi);
  for_each_row(*team_, layout, [&](int j) {
    for (int colour = 0; colour < 2; ++colour)
      with_neighbours(colour, j, [&](std::ptrdiff_t at, int n, const auto& around) {
        residual_row(n, &f[at], &f[at], &v[at], &inverse_diagonal_[at], around);
      });
    add_link_fluxes(j, phi);
  });
  add_group_residuals(charge);
}

}  // namespace lichtenberg::laplace
