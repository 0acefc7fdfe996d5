#include "solvers/laplace/cutcell/operator.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include "solvers/laplace/cutcell/wavefront.hpp"

namespace lichtenberg::laplace {

void CutCellOperator::build(const LaplaceProblem& problem, const Level& level, parallel::Team& team) {
  level_ = &level;
  team_ = &team;
  cells_ = level.layout.size();
  groups_ = problem.groups.size();
  links_.build(problem, level, team);
  if (level.faces.are_uniform()) edges_.build(level, links_, team);
  group_diagonal_ = group_diagonals(problem, level, links_, team);
  pairs_.clear();
  for (const PairLink& pair : level.pairs) {
    const int a = problem.bodies[pair.body_a].group, b = problem.bodies[pair.body_b].group;
    if (problem.groups[a].floating && problem.groups[b].floating) pairs_.push_back({a, b, pair.conductance});
  }
  grounded_by_couplings_ = problem.has_ground() && !problem.has_fixed_conductor();
  if (are_linked()) factorize_groups();
}

/// Factorizes the equations of all groups together, because sequential relaxation of strongly coupled groups would
/// retain their common potential.
void CutCellOperator::factorize_groups() {
  std::vector<double> ground = group_diagonal_;
  std::vector<NetworkLink> links = level_->couplings;
  for (const NetworkLink& pair : pairs_) {
    ground[pair.a] = std::max(0.0, ground[pair.a] - pair.conductance);
    ground[pair.b] = std::max(0.0, ground[pair.b] - pair.conductance);
    links.push_back(pair);
  }
  for (const FixedCoupling& coupling : level_->fixed_couplings) ground[coupling.group] += coupling.conductance;
  group_factors_ = NetworkFactors(std::move(ground), links);
}

template <class Real>
void CutCellOperator::apply_cells(int colour, int j, const Real* x, double* y) const {
  const Layout& at = level_->layout;
  const std::ptrdiff_t row = at.row(colour, j), other = 1 - colour;
  const Real* __restrict west = x + at.row(other, j) + Layout::parity(colour, j) - 1;
  const Real* __restrict south = x + at.row(other, j - 1);
  const Real* __restrict north = x + at.row(other, j + 1);
  const Real* __restrict own = x + row;
  const double* __restrict diagonal = level_->diagonal.data() + row;
  double* __restrict out = y;
  const int n = at.row_length(colour, j);
  for (int k = 0; k < n; ++k) {
    const double around = (static_cast<double>(west[k]) + static_cast<double>(west[k + 1])) +
                          (static_cast<double>(south[k]) + static_cast<double>(north[k]));
    const double value = diagonal[k] * static_cast<double>(own[k]) - around;
    out[k] = diagonal[k] > 0 ? value : 0.0;
  }
  if (!level_->faces.are_uniform()) subtract_closed_faces(colour, j, x, y);
}

/// Removes from the cells of a colour in row j the flux through the closed parts of faces, which apply_cells takes as
/// open.
template <class Real>
void CutCellOperator::subtract_closed_faces(int colour, int j, const Real* x, double* y) const {
  const Layout& at = level_->layout;
  const std::vector<float>&east = level_->faces.east, &north = level_->faces.north;
  for (int i = Layout::parity(colour, j); i < at.nx; i += 2) {
    const std::ptrdiff_t slot = at(i, j);
    if (!level_->owner[slot].is_fluid()) continue;
    const auto closed = [&](float open, std::ptrdiff_t neighbour) { y[i / 2] += (1.0 - open) * x[neighbour]; };
    if (i > 0) closed(east[at(i - 1, j)], at(i - 1, j));
    if (i + 1 < at.nx) closed(east[slot], at(i + 1, j));
    if (j > 0) closed(north[at(i, j - 1)], at(i, j - 1));
    if (j + 1 < at.ny) closed(north[slot], at(i, j + 1));
  }
}

/// Computes y = A x for the cells of row j, by colour.
template <class Real>
void CutCellOperator::apply_links(int j, const Real* x, const double* x_group, std::array<double*, 2> y) const {
  const Layout& at = level_->layout;
  for (int colour = 0; colour < 2; ++colour) apply_cells(colour, j, x, y[colour]);
  const std::ptrdiff_t red = at.row(0, j), black = at.row(1, j);
  links_.add_to_row(j, x_group, [&](std::int32_t cell, double flux) {
    (cell < at.colour_size() ? y[0][cell - red] : y[1][cell - black]) -= flux;
  });
}

namespace {

/// Memory of the calling thread for a row of each colour.
std::array<double*, 2> row_buffers(const Layout& at) {
  thread_local std::vector<double> buffer;
  if (static_cast<std::ptrdiff_t>(buffer.size()) < 2 * at.stride) buffer.resize(2 * at.stride);
  return {buffer.data(), buffer.data() + at.stride};
}

}  // namespace

template <class Real>
double CutCellOperator::apply_row(int j, const Real* x, const double* x_group, Real* y) const {
  const Layout& at = level_->layout;
  const std::array<double*, 2> image = row_buffers(at);
  apply_links(j, x, x_group, image);
  double product = 0;
  for (int colour = 0; colour < 2; ++colour) {
    const int n = at.row_length(colour, j);
    product += row_dot(n, image[colour], x + at.row(colour, j));
    const double* __restrict from = image[colour];
    Real* __restrict to = y + at.row(colour, j);
    for (int k = 0; k < n; ++k) to[k] = static_cast<Real>(from[k]);
  }
  return product;
}

/// Computes row j of r = b - A x, and the row's scalar products.
CutCellOperator::RowProducts CutCellOperator::residual_row(int j, const double* b, const double* x, float* r) const {
  const Layout& at = level_->layout;
  const std::array<double*, 2> image = row_buffers(at);
  apply_links(j, x, x + cells_, image);
  RowProducts products;
  for (int colour = 0; colour < 2; ++colour) {
    const std::ptrdiff_t row = at.row(colour, j);
    const int n = at.row_length(colour, j);
    products.energy += row_dot(n, image[colour], x + row);
    products.right_hand_side += row_dot(n, b + row, x + row);
    const double* __restrict given = b + row, * __restrict flux = image[colour];
    float* __restrict to = r + row;
    for (int k = 0; k < n; ++k) to[k] = static_cast<float>(given[k] - flux[k]);
  }
  return products;
}

template <class Real>
double CutCellOperator::apply_groups(const Real* x, const double* x_group, double* y_group) const {
  const double product = apply_field_to_groups(x, x_group, y_group);
  return level_->is_coupled() ? product + apply_couplings(x_group, y_group) : product;
}

template <class Real>
double CutCellOperator::apply_field_to_groups(const Real* x, const double* x_group, double* y_group) const {
  std::fill_n(y_group, groups_, 0.0);
  add_cell_fluxes(x, y_group);
  for (const NetworkLink& pair : pairs_) {
    y_group[pair.a] += pair.conductance * x_group[pair.b];
    y_group[pair.b] += pair.conductance * x_group[pair.a];
  }
  double product = 0;
  for (std::size_t g = 0; g < groups_; ++g) {
    y_group[g] = group_diagonal_[g] > 0 ? group_diagonal_[g] * x_group[g] - y_group[g] : 0.0;
    product += x_group[g] * y_group[g];
  }
  return product;
}

/// Adds the fluxes of couplings (lumped capacitances) to y and returns their part of x'y. The flux out of one group is
/// exactly that into the other, also if a strong coupling makes rounding errors dominate it.
double CutCellOperator::apply_couplings(const double* x_group, double* y_group) const {
  double product = 0;
  for (const auto& [a, b, conductance] : level_->couplings) {
    const double difference = x_group[a] - x_group[b], flux = conductance * difference;
    y_group[a] += flux;
    y_group[b] -= flux;
    product += flux * difference;
  }
  for (const FixedCoupling& coupling : level_->fixed_couplings) {
    const double flux = coupling.conductance * x_group[coupling.group];
    y_group[coupling.group] += flux;
    product += flux * x_group[coupling.group];
  }
  return product;
}

void CutCellOperator::apply(const double* x, double* y) const {
  std::fill(y, y + cells_, 0.0);  // the padding
  for_each_row(*team_, level_->layout, [&](int j) { apply_row(j, x, x + cells_, y); });
  apply_groups(x, x + cells_, y + cells_);
}

void CutCellOperator::residual(const double* b, const double* x, SplitVector& r) const {
  for_each_row(*team_, level_->layout, [&](int j) { residual_row(j, b, x, r.cell.data()); });
  apply_groups(x, x + cells_, r.group.data());
  for (std::size_t g = 0; g < groups_; ++g) r.group[g] = b[cells_ + g] - r.group[g];
}

double CutCellOperator::stretch(const double* b, double* x, SplitVector& r) const {
  constexpr double least_change = 5e-4;  // below the error of any guess
  const Layout& at = level_->layout;
  std::vector<double> energies(at.ny), products(at.ny);
  for_each_row(*team_, at, [&](int j) {
    const RowProducts row = residual_row(j, b, x, r.cell.data());
    energies[j] = row.energy, products[j] = row.right_hand_side;
  });
  double* x_group = x + cells_;
  const double *b_group = b + cells_,
               field_energy = ordered_sum(energies) + apply_field_to_groups(x, x_group, r.group.data());
  const double energy = level_->is_coupled() ? field_energy + apply_couplings(x_group, r.group.data()) : field_energy;
  const double product = ordered_sum(products) + row_dot(static_cast<int>(groups_), x_group, b_group);
  const double best = energy > 0 ? product / energy : 0.0, factor = std::abs(best - 1) < least_change ? 1.0 : best;
  for (std::size_t g = 0; g < groups_; ++g) {
    r.group[g] = b_group[g] - factor * r.group[g];
    x_group[g] *= factor;
  }
  if (factor != 1)
    for_each_row(*team_, at, [&](int j) {
      for (int colour = 0; colour < 2; ++colour) {
        const std::ptrdiff_t row = at.row(colour, j);
        float* __restrict cell = r.cell.data() + row;
        const double* __restrict given = b + row;
        double* __restrict potential = x + row;
        const double by = factor;  // a local copy, so that the compiler vectorizes the loop
        for (int k = 0; k < at.row_length(colour, j); ++k) {
          potential[k] *= by;
          cell[k] = static_cast<float>(by * cell[k] + (1 - by) * given[k]);
        }
      }
    });
  // The energy of couplings is not part of the field's energy. Without a field, rounding may make the latter negative.
  const double not_negative = std::max(field_energy, 0.0);
  return level_->is_coupled() ? std::abs(factor) * std::sqrt(not_negative) : std::sqrt(std::max(best * product, 0.0));
}

void CutCellOperator::right_hand_side(const LaplaceProblem& problem, double* b, double scale) const {
  write_right_hand_side(problem, *level_, scale, b, b + cells_);
}

void CutCellOperator::shift_cells(double value, double* x) const {
  for_each_row(*team_, level_->layout, [&](int j) {
    for (int colour = 0; colour < 2; ++colour) {
      const std::ptrdiff_t row = level_->layout.row(colour, j);
      const int n = level_->layout.row_length(colour, j);
      const double* __restrict diagonal = level_->diagonal.data() + row;
      double* __restrict to = x + row;
      const double shift = value;  // a local copy, so that the compiler vectorizes the loop
      for (int k = 0; k < n; ++k) to[k] += diagonal[k] > 0 ? shift : 0.0;
    }
  });
}

void CutCellOperator::fix_potential_level(double* x, SplitVector& r) const {
  const Layout& at = level_->layout;
  std::vector<double> row_sum(at.ny);
  for_each_row(*team_, at, [&](int j) {
    for (int colour = 0; colour < 2; ++colour)
      for (int k = 0; k < at.row_length(colour, j); ++k) row_sum[j] += r.cell[at.row(colour, j) + k];
  });
  const double sum = std::accumulate(r.group.begin(), r.group.end(), ordered_sum(row_sum));
  double conductance = 0;
  for (const FixedCoupling& coupling : level_->fixed_couplings) conductance += coupling.conductance;
  const double shift = sum / conductance;
  shift_cells(shift, x);
  for (std::size_t g = 0; g < groups_; ++g)
    if (group_diagonal_[g] > 0) x[cells_ + g] += shift;
  for (const FixedCoupling& coupling : level_->fixed_couplings) r.group[coupling.group] -= coupling.conductance * shift;
}

double CutCellOperator::relax_edges(const double* b, double* x, int sweeps) const {
  const Layout& at = level_->layout;
  if (!level_->faces.are_uniform()) return 0;
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    relax_groups(b, x);
    wavefront(*team_, at, 2, [&](int colour, int j) { relax_edges_of_row(colour, j, b, x); });
  }
  relax_groups(b, x);
  return sweeps * static_cast<double>(edges_.size()) / (static_cast<double>(at.nx) * at.ny);
}

void CutCellOperator::relax_groups(const double* b, double* x) const {
  std::vector<double> flux(b + cells_, b + size());
  links_.add_to_groups(*team_, x, flux.data());
  if (level_->is_coupled()) {
    group_factors_.solve(flux.data());
    for (std::size_t g = 0; g < groups_; ++g)
      if (group_diagonal_[g] > 0) x[cells_ + g] = flux[g];
    return;
  }
  for (const NetworkLink& pair : pairs_) {
    flux[pair.a] += pair.conductance * x[cells_ + pair.b];
    flux[pair.b] += pair.conductance * x[cells_ + pair.a];
  }
  for (std::size_t g = 0; g < groups_; ++g)
    if (group_diagonal_[g] > 0) x[cells_ + g] = flux[g] / group_diagonal_[g];
}

void CutCellOperator::relax_edges_of_row(int colour, int j, const double* b, double* x) const {
  const Layout& at = level_->layout;
  const std::ptrdiff_t row = at.row(colour, j), other = 1 - colour;
  const std::ptrdiff_t east = at.row(other, j) + Layout::parity(colour, j) - row;
  const std::ptrdiff_t below = at.row(other, j - 1) - row, above = at.row(other, j + 1) - row;
  // The links are summed first: their number varies from cell to cell, which would stall a loop over cells.
  const std::span<const EdgeCells::Cell> cells = edges_.cells(colour, j);
  double* __restrict flux = row_buffers(at)[0];
  std::fill_n(flux, cells.size(), 0.0);
  edges_.for_each_link(colour, j, [&](int link, int k) { flux[k] += links_.flux(link, x + cells_); });
  for (std::size_t k = 0; k < cells.size(); ++k) {
    const auto [cell, inverse_diagonal] = cells[k];
    x[cell] = (b[cell] + flux[k] + x[cell + east - 1] + x[cell + east] + x[cell + below] + x[cell + above]) *
              inverse_diagonal;
  }
}

template void CutCellOperator::apply_cells(int, int, const float*, double*) const;
template void CutCellOperator::apply_cells(int, int, const double*, double*) const;
template double CutCellOperator::apply_row(int, const float*, const double*, float*) const;
template double CutCellOperator::apply_groups(const float*, const double*, double*) const;
template double CutCellOperator::apply_groups(const double*, const double*, double*) const;

void CutCellOperator::mask(double* x) const {
  for (const std::ptrdiff_t slot : level_->covered) x[slot] = 0;
  for (std::size_t g = 0; g < groups_; ++g)
    if (group_diagonal_[g] == 0) x[cells_ + g] = 0;
}

}  // namespace lichtenberg::laplace
