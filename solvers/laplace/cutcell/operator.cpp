#include "solvers/laplace/cutcell/operator.hpp"

#include <algorithm>
#include <cmath>

#include "solvers/laplace/cutcell/wavefront.hpp"

namespace lichtenberg::laplace {

void CutCellOperator::build(const LaplaceProblem& problem, const Level& level, Team& team) {
  level_ = &level;
  team_ = &team;
  cells_ = level.layout.size();
  groups_ = problem.groups.size();
  links_.build(problem, level, team);
  group_diagonal_ = group_diagonals(problem, level, links_, team);
  pairs_.clear();
  for (const PairLink& pair : level.pairs) {
    const int a = problem.bodies[pair.body_a].group, b = problem.bodies[pair.body_b].group;
    if (problem.groups[a].floating && problem.groups[b].floating) pairs_.push_back({a, b, pair.conductance});
  }
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
  if (!level_->east.empty()) narrow_row(j, x, y);
  links_.add_to_row(j, x + cells_, [y](std::int32_t cell, double flux) { y[cell] -= flux; });
  double product = 0;
  for (int colour = 0; colour < 2; ++colour)
    product += row_dot(at.row_length(colour, j), x + at.row(colour, j), y + at.row(colour, j));
  return product;
}

/// What is too much in a row of `apply_row` where faces are not wholly open.
void CutCellOperator::narrow_row(int j, const double* x, double* y) const {
  const Layout& at = level_->layout;
  const std::vector<float>&east = level_->east, &north = level_->north;
  for (int i = 0; i < at.nx; ++i) {
    const std::ptrdiff_t slot = at(i, j);
    if (level_->cover[slot] >= 0) continue;
    const auto closed = [&](float open, std::ptrdiff_t neighbour) { y[slot] += (1.0 - open) * x[neighbour]; };
    if (i > 0) closed(east[at(i - 1, j)], at(i - 1, j));
    if (i + 1 < at.nx) closed(east[slot], at(i + 1, j));
    if (j > 0) closed(north[at(i, j - 1)], at(i, j - 1));
    if (j + 1 < at.ny) closed(north[slot], at(i, j + 1));
  }
}

double CutCellOperator::apply_groups(const double* x, double* y_group) const {
  const double* x_group = x + cells_;
  std::fill_n(y_group, groups_, 0.0);
  links_.add_to_groups(*team_, x, y_group);
  for (const GroupPair& pair : pairs_) {
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

void CutCellOperator::apply(const double* x, double* y) const {
  std::fill(y, y + cells_, 0.0);  // the padding
  for_each_row(*team_, level_->layout, [&](int j) { apply_row(j, x, y); });
  apply_groups(x, y + cells_);
}

double CutCellOperator::stretch(const double* b, double* x, double* r) const {
  const Layout& at = level_->layout;
  const int groups = static_cast<int>(groups_);
  std::vector<double> row_energy(at.ny), row_product(at.ny);
  for_each_row(*team_, at, [&](int j) {
    row_energy[j] = apply_row(j, x, r);
    for (int colour = 0; colour < 2; ++colour)
      row_product[j] += row_dot(at.row_length(colour, j), x + at.row(colour, j), b + at.row(colour, j));
  });
  const double energy = ordered_sum(row_energy) + apply_groups(x, r + cells_);
  const double product = ordered_sum(row_product) + row_dot(groups, x + cells_, b + cells_);
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
  return std::sqrt(factor * product);
}

void CutCellOperator::right_hand_side(const LaplaceProblem& problem, double* b, double scale) const {
  write_right_hand_side(problem, *level_, scale, b, b + cells_);
}

double CutCellOperator::relax_edges(const double* b, double* x, int sweeps) const {
  const Layout& at = level_->layout;
  if (!level_->east.empty()) return 0;
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    relax_groups(b, x);
    for (int colour = 0; colour < 2; ++colour)
      for_each_row(*team_, at, [&](int j) { relax_edges_of_row(colour, j, b, x); });
  }
  relax_groups(b, x);
  return sweeps * static_cast<double>(level_->links.size()) / (static_cast<double>(at.nx) * at.ny);
}

void CutCellOperator::relax_groups(const double* b, double* x) const {
  std::vector<double> flux(b + cells_, b + size());
  links_.add_to_groups(*team_, x, flux.data());
  for (const GroupPair& pair : pairs_) {
    flux[pair.a] += pair.conductance * x[cells_ + pair.b];
    flux[pair.b] += pair.conductance * x[cells_ + pair.a];
  }
  for (std::size_t g = 0; g < groups_; ++g)
    if (group_diagonal_[g] > 0) x[cells_ + g] = flux[g] / group_diagonal_[g];
}

void CutCellOperator::relax_edges_of_row(int colour, int j, const double* b, double* x) const {
  const Layout& at = level_->layout;
  const std::ptrdiff_t row = at.row(colour, j), other = 1 - colour;
  const std::ptrdiff_t beside = at.row(other, j) + Layout::parity(colour, j) - row;
  const std::ptrdiff_t below = at.row(other, j - 1) - row, above = at.row(other, j + 1) - row;
  links_.for_linked_cells(colour, j, x + cells_, [&](std::int32_t cell, double flux) {
    x[cell] = (b[cell] + flux + x[cell + beside - 1] + x[cell + beside] + x[cell + below] + x[cell + above]) /
              level_->diagonal[cell];
  });
}

void CutCellOperator::mask(double* x) const {
  for (const std::ptrdiff_t slot : level_->covered) x[slot] = 0;
  for (std::size_t g = 0; g < groups_; ++g)
    if (group_diagonal_[g] == 0) x[cells_ + g] = 0;
}

}  // namespace lichtenberg::laplace
