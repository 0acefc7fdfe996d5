#include "solvers/laplace/cutcell/operator.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

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

double CutCellOperator::apply_row(int j, const double* x, double* y) const {
  const Layout& at = level_->layout;
  for (int colour = 0; colour < 2; ++colour) {
    const std::ptrdiff_t row = at.row(colour, j), other = 1 - colour;
    const double* __restrict west = x + at.row(other, j) + Layout::parity(colour, j) - 1;
    const double* __restrict south = x + at.row(other, j - 1);
    const double* __restrict north = x + at.row(other, j + 1);
    const double* __restrict own = x + row;
    const double* __restrict diagonal = level_->diagonal.data() + row;
    double* __restrict out = y + row;
    const int n = at.row_length(colour, j);
    for (int k = 0; k < n; ++k) {
      const double value = diagonal[k] * own[k] - (west[k] + west[k + 1] + south[k] + north[k]);
      out[k] = diagonal[k] > 0 ? value : 0.0;
    }
  }
  if (!level_->faces.are_uniform()) subtract_closed_faces(j, x, y);
  links_.add_to_row(j, x + cells_, [y](std::int32_t cell, double flux) { y[cell] -= flux; });
  double product = 0;
  for (int colour = 0; colour < 2; ++colour)
    product += row_dot(at.row_length(colour, j), x + at.row(colour, j), y + at.row(colour, j));
  return product;
}

/// Removes from row j of y the flux through the closed parts of faces, which apply_row takes as open.
void CutCellOperator::subtract_closed_faces(int j, const double* x, double* y) const {
  const Layout& at = level_->layout;
  const std::vector<float>&east = level_->faces.east, &north = level_->faces.north;
  for (int i = 0; i < at.nx; ++i) {
    const std::ptrdiff_t slot = at(i, j);
    if (!level_->owner[slot].is_fluid()) continue;
    const auto closed = [&](float open, std::ptrdiff_t neighbour) { y[slot] += (1.0 - open) * x[neighbour]; };
    if (i > 0) closed(east[at(i - 1, j)], at(i - 1, j));
    if (i + 1 < at.nx) closed(east[slot], at(i + 1, j));
    if (j > 0) closed(north[at(i, j - 1)], at(i, j - 1));
    if (j + 1 < at.ny) closed(north[slot], at(i, j + 1));
  }
}

double CutCellOperator::apply_groups(const double* x, double* y_group) const {
  const double product = apply_field_to_groups(x, y_group);
  return level_->is_coupled() ? product + apply_couplings(x + cells_, y_group) : product;
}

double CutCellOperator::apply_field_to_groups(const double* x, double* y_group) const {
  const double* x_group = x + cells_;
  std::fill_n(y_group, groups_, 0.0);
  links_.add_to_groups(*team_, x, y_group);
  add_over_slabs(level_->layout, y_group, std::ssize(group_diagonal_));
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
  for_each_row(*team_, level_->layout, [&](int j) { apply_row(j, x, y); });
  apply_groups(x, y + cells_);
}

double CutCellOperator::stretch(const double* b, double* x, double* r) const {
  const Layout& at = level_->layout;
  const int groups = static_cast<int>(groups_);
  std::vector<double> row_energy(at.ny), row_product(at.ny);
  exchange_ghosts(at, x, 1);
  for_each_row(*team_, at, [&](int j) {
    row_energy[j] = apply_row(j, x, r);
    for (int colour = 0; colour < 2; ++colour)
      row_product[j] += row_dot(at.row_length(colour, j), x + at.row(colour, j), b + at.row(colour, j));
  });
  const double field_energy = ordered_sum(at, row_energy) + apply_field_to_groups(x, r + cells_);
  const double energy = level_->is_coupled() ? field_energy + apply_couplings(x + cells_, r + cells_) : field_energy;
  const double product = ordered_sum(at, row_product) + row_dot(groups, x + cells_, b + cells_);
  const double factor = energy > 0 ? product / energy : 0.0;
  const auto rescale = [=](std::ptrdiff_t from, int count) {
#pragma GCC ivdep
    for (std::ptrdiff_t k = from; k < from + count; ++k) {
      x[k] *= factor;
      r[k] = b[k] - factor * r[k];
    }
  };
  for_each_row(*team_, at, [&](int j) {
    for (int colour = 0; colour < 2; ++colour) rescale(at.row(colour, j), at.row_length(colour, j));
  });
  rescale(static_cast<std::ptrdiff_t>(cells_), groups);
  // The energy of couplings is not part of the field's energy. Without a field, rounding may make the latter negative.
  const double not_negative = std::max(field_energy, 0.0);
  return level_->is_coupled() ? std::abs(factor) * std::sqrt(not_negative) : std::sqrt(factor * product);
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

void CutCellOperator::fix_potential_level(double* x, double* r) const {
  const Layout& at = level_->layout;
  std::vector<double> row_sum(at.ny);
  for_each_row(*team_, at, [&](int j) {
    for (int colour = 0; colour < 2; ++colour)
      row_sum[j] += std::accumulate(r + at.row(colour, j), r + at.row(colour, j) + at.row_length(colour, j), 0.0);
  });
  const double sum = std::accumulate(r + cells_, r + size(), ordered_sum(at, row_sum));
  double conductance = 0;
  for (const FixedCoupling& coupling : level_->fixed_couplings) conductance += coupling.conductance;
  const double shift = sum / conductance;
  shift_cells(shift, x);
  for (std::size_t g = 0; g < groups_; ++g)
    if (group_diagonal_[g] > 0) x[cells_ + g] += shift;
  for (const FixedCoupling& coupling : level_->fixed_couplings)
    r[cells_ + coupling.group] -= coupling.conductance * shift;
}

double CutCellOperator::relax_edges(const double* b, double* x, int sweeps) const {
  const Layout& at = level_->layout;
  if (!level_->faces.are_uniform()) return 0;
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    exchange_ghosts(at, x, 2);
    relax_groups(b, x);
    for (int colour = 0; colour < 2; ++colour)
      for_each_row(*team_, at, at.extended(1 - colour), [&](int j) { relax_edges_of_row(colour, j, b, x); });
  }
  relax_groups(b, x);
  const double cells = sum_over_slabs(at, static_cast<double>(edges_.size()));
  return sweeps * cells / (static_cast<double>(at.nx) * at.ny);
}

void CutCellOperator::relax_groups(const double* b, double* x) const {
  std::vector<double> flux(b + cells_, b + size());
  add_sums(level_->layout, std::ssize(flux), flux.data(), [&](double* sum) { links_.add_to_groups(*team_, x, sum); });
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
  edges_.for_each(colour, j, [&](std::int32_t cell, int first, int end, double inverse_diagonal) {
    const double flux = links_.flux(first, end, x + cells_);
    x[cell] =
        (b[cell] + flux + x[cell + east - 1] + x[cell + east] + x[cell + below] + x[cell + above]) * inverse_diagonal;
  });
}

void CutCellOperator::mask(double* x) const {
  for (const std::ptrdiff_t slot : level_->covered) x[slot] = 0;
  for (std::size_t g = 0; g < groups_; ++g)
    if (group_diagonal_[g] == 0) x[cells_ + g] = 0;
}

}  // namespace lichtenberg::laplace
