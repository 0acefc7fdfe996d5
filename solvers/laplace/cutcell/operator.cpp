#include "solvers/laplace/cutcell/operator.hpp"

#include <Eigen/Sparse>
#include <algorithm>

namespace lichtenberg::laplace {

void CutCellOperator::build(const LaplaceProblem& problem, const Level& level) {
  level_ = &level;
  cells_ = level.layout.size();
  groups_ = problem.groups.size();
  link_cell_.clear();
  link_group_.clear();
  link_conductance_.clear();
  pairs_.clear();
  to_ground_.clear();
  group_diagonal_.assign(groups_, 0.0);
  const auto group = [&](int body) { return problem.bodies[body].group; };
  const auto floating = [&](int g) { return problem.groups[g].floating; };
  for (const Link& link : level.links) {
    const int g = group(link.body);
    if (!floating(g)) {
      to_ground_.emplace_back(static_cast<std::int32_t>(link.cell), link.conductance);
      continue;
    }
    group_diagonal_[g] += link.conductance;
    link_cell_.push_back(static_cast<std::int32_t>(link.cell));
    link_group_.push_back(static_cast<std::int32_t>(cells_) + g);
    link_conductance_.push_back(link.conductance);
  }
  for (const PairLink& pair : level.pairs) {
    const int a = group(pair.body_a), b = group(pair.body_b);
    if (floating(a)) group_diagonal_[a] += pair.conductance;
    if (floating(b)) group_diagonal_[b] += pair.conductance;
    if (floating(a) && floating(b))
      pairs_.push_back(
          {static_cast<std::int32_t>(cells_) + a, static_cast<std::int32_t>(cells_) + b, pair.conductance});
    else if (floating(a) || floating(b))
      to_ground_.emplace_back(static_cast<std::int32_t>(cells_) + (floating(a) ? a : b), pair.conductance);
  }
  for (const SideLink& link : level.side_links) {
    if (link.body < 0) {
      to_ground_.emplace_back(static_cast<std::int32_t>(link.cell), link.conductance);
    } else if (const int g = group(link.body); floating(g)) {
      group_diagonal_[g] += link.conductance;
      to_ground_.emplace_back(static_cast<std::int32_t>(cells_) + g, link.conductance);
    }
  }
}

void CutCellOperator::apply(const double* x, double* y) const {
  const Layout& at = level_->layout;
  std::fill(y, y + cells_, 0.0);
  for (int j = 0; j < at.ny; ++j)
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
  for (std::size_t g = 0; g < groups_; ++g) y[cells_ + g] = group_diagonal_[g] * x[cells_ + g];
  for (std::size_t m = 0; m < link_cell_.size(); ++m) {
    y[link_cell_[m]] -= link_conductance_[m] * x[link_group_[m]];
    y[link_group_[m]] -= link_conductance_[m] * x[link_cell_[m]];
  }
  for (const GroupPair& pair : pairs_) {
    y[pair.a] -= pair.conductance * x[pair.b];
    y[pair.b] -= pair.conductance * x[pair.a];
  }
}

void CutCellOperator::right_hand_side(const LaplaceProblem& problem, double* b) const {
  std::fill(b, b + size(), 0.0);
  double* b_group = b + cells_;
  for (std::size_t g = 0; g < groups_; ++g)
    if (problem.groups[g].floating) b_group[g] = problem.groups[g].charge / problem.permittivity;
  const auto group = [&](int body) -> const Group& { return problem.groups[problem.bodies[body].group]; };
  for (const Link& link : level_->links)
    if (!group(link.body).floating) b[link.cell] += link.conductance * group(link.body).potential;
  for (const PairLink& pair : level_->pairs) {
    const Group &a = group(pair.body_a), &c = group(pair.body_b);
    if (a.floating && !c.floating) b_group[problem.bodies[pair.body_a].group] += pair.conductance * c.potential;
    if (c.floating && !a.floating) b_group[problem.bodies[pair.body_b].group] += pair.conductance * a.potential;
  }
  for (const SideLink& link : level_->side_links) {
    if (link.cell >= 0)
      b[link.cell] += link.conductance * link.potential;
    else if (group(link.body).floating)
      b_group[problem.bodies[link.body].group] += link.conductance * link.potential;
  }
}

std::vector<double> CutCellOperator::group_residual(const double* b, const double* x) const {
  std::vector<double> residual(b + cells_, b + size());
  for (std::size_t g = 0; g < groups_; ++g) residual[g] -= group_diagonal_[g] * x[cells_ + g];
  for (std::size_t m = 0; m < link_cell_.size(); ++m)
    residual[link_group_[m] - cells_] += link_conductance_[m] * x[link_cell_[m]];
  for (const GroupPair& pair : pairs_) {
    residual[pair.a - cells_] += pair.conductance * x[pair.b];
    residual[pair.b - cells_] += pair.conductance * x[pair.a];
  }
  return residual;
}

/// The equations of the groups among themselves, the cells' potentials given; 1 in the rows of fixed groups.
Eigen::SparseMatrix<double> CutCellOperator::group_matrix() const {
  const auto n = static_cast<int>(groups_);
  std::vector<Eigen::Triplet<double>> entries;
  for (int g = 0; g < n; ++g) entries.emplace_back(g, g, group_diagonal_[g] > 0 ? group_diagonal_[g] : 1.0);
  for (const GroupPair& pair : pairs_) {
    const int a = pair.a - static_cast<int>(cells_), c = pair.b - static_cast<int>(cells_);
    entries.emplace_back(std::max(a, c), std::min(a, c), -pair.conductance);
  }
  Eigen::SparseMatrix<double> matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

void CutCellOperator::balance(const double* b, double* x) const {
  const auto n = static_cast<Eigen::Index>(groups_);
  const std::vector<double> residual = group_residual(b, x);
  // Unknowns: a shift y of each group, and a shift of all by `level`, which only links to given potentials notice.
  double missing = 0, conductance = 0;
  for (std::size_t k = 0; k < size(); ++k) missing += b[k];
  Eigen::VectorXd group_to_ground = Eigen::VectorXd::Zero(n);
  for (const auto& [index, c] : to_ground_) {
    missing -= c * x[index];
    conductance += c;
    if (static_cast<std::size_t>(index) >= cells_) group_to_ground[index - static_cast<Eigen::Index>(cells_)] += c;
  }
  Eigen::VectorXd shift = Eigen::VectorXd::Zero(n), with_level = shift;
  if (n > 0) {
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> groups(group_matrix());
    shift = groups.solve(Eigen::Map<const Eigen::VectorXd>(residual.data(), n));
    with_level = groups.solve(group_to_ground);
  }
  double level = 0;
  if (conductance > 0) {
    level = (missing - group_to_ground.dot(shift)) / (conductance - group_to_ground.dot(with_level));
    for (std::size_t k = 0; k < cells_; ++k) x[k] += level_->diagonal[k] > 0 ? level : 0.0;
  }
  for (Eigen::Index g = 0; g < n; ++g)
    if (group_diagonal_[g] > 0) x[cells_ + g] += shift[g] + level * (1 - with_level[g]);
}

void CutCellOperator::mask(double* x) const {
  for (const std::ptrdiff_t slot : level_->covered) x[slot] = 0;
  for (std::size_t g = 0; g < groups_; ++g)
    if (group_diagonal_[g] == 0) x[cells_ + g] = 0;
}

}  // namespace lichtenberg::laplace
