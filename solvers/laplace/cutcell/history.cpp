#include "solvers/laplace/cutcell/history.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "solvers/laplace/cutcell/wavefront.hpp"
#include "solvers/parallel/huge_pages.hpp"

namespace lichtenberg::laplace {

namespace {

/// Calls entries(first slot, number of slots) for all unknowns, in bands of rows on the team; then for the groups.
template <class Entries>
void for_all_unknowns(const CutCellOperator& op, const Entries& entries) {
  const Layout& at = op.level().layout;
  for_each_row(op.team(), at, [&](int j) {
    for (int colour = 0; colour < 2; ++colour) entries(at.row(colour, j), at.row_length(colour, j));
  });
  entries(static_cast<std::ptrdiff_t>(op.cells()), static_cast<int>(op.size() - op.cells()));
}

/// Sets covered cells of a row to zero.
void mask_row(const CutCellOperator& op, std::ptrdiff_t row, int count, double* __restrict x) {
  if (row >= static_cast<std::ptrdiff_t>(op.cells())) return;
  const double* __restrict diagonal = op.level().diagonal.data();
  for (std::ptrdiff_t k = row; k < row + count; ++k) x[k] = diagonal[k] > 0 ? x[k] : 0.0;
}

}  // namespace

/// Group potentials of the past solutions: a new group's is the mean of its members'.
void History::set_groups(const LaplaceProblem& problem, std::size_t cells) {
  std::vector<int> members(problem.groups.size(), 0);
  for (const Body& body : problem.bodies) ++members[body.group];
  for (Past& past : past_) {
    past.x.resize(cells + problem.groups.size());
    std::fill(past.x.begin() + cells, past.x.end(), 0.0);
    for (std::size_t body = 0; body < problem.bodies.size(); ++body) {
      const int g = problem.bodies[body].group;
      if (problem.groups[g].floating) past.x[cells + g] += past.body[body] / members[g];
    }
  }
}

/// What the newest solution and successive differences have where the solutions have these: a basis that is nearly
/// orthogonal where the solutions are nearly parallel.
History::Values History::basis(const Values& of_past) {
  return {of_past[0], of_past[0] - of_past[1], of_past[1] - of_past[2]};
}

void History::Products::add(const Products& other) {
  for (int p = 0; p < length; ++p) {
    for (int q = 0; q <= p; ++q) gram[p][q] += other.gram[p][q];
    rhs[p] += other.rhs[p];
  }
}

/// Of one unknown: the solutions' values, the operator's of them, and b's.
void History::add_entry(const Values& past, const Values& image, double b, Products& products) {
  const Values value = basis(past), of_value = basis(image);
  for (int p = 0; p < length; ++p) {
    for (int q = 0; q <= p; ++q) products.gram[p][q] += value[q] * of_value[p];
    products.rhs[p] += value[p] * b;
  }
}

History::Products History::products(const CutCellOperator& op, const std::vector<double>& b) const {
  const int m = static_cast<int>(past_.size());
  std::array<const double*, length> x;  // of fewer the oldest several times
  for (int p = 0; p < length; ++p) x[p] = past_[std::min(p, m - 1)].x.data();
  const auto at = [&](std::size_t unknown) { return Values{x[0][unknown], x[1][unknown], x[2][unknown]}; };
  std::vector<Products> of_row(op.level().layout.ny);
  for_each_row(op.team(), op.level().layout, [&](int j) {
    Products sum;
    op.apply_at_edges(j, x, [&](std::int32_t cell, const Values& image) { add_entry(at(cell), image, b[cell], sum); });
    of_row[j] = sum;
  });
  Products all;
  for (const Products& row : of_row) all.add(row);
  const std::size_t groups = op.size() - op.cells();
  std::array<std::vector<double>, length> image;
  for (int p = 0; p < length; ++p) {
    image[p].resize(groups);
    op.apply_groups(x[p], image[p].data());
  }
  for (std::size_t g = 0; g < groups; ++g)
    add_entry(at(op.cells() + g), {image[0][g], image[1][g], image[2][g]}, b[op.cells() + g], all);
  return all;
}

double History::first_guess(const LaplaceProblem& problem, const CutCellOperator& op, const std::vector<double>& b,
                            std::vector<double>& x) {
  if (!op.level().east.empty()) {  // apertures
    newest_guess(problem, op, x);
    return 0;
  }
  set_groups(problem, op.cells());
  const Products known = products(op, b);
  const int m = static_cast<int>(past_.size());
  std::vector<double> gram(m * m);
  for (int p = 0; p < m; ++p)
    for (int q = 0; q <= p; ++q) gram[p * m + q] = gram[q * m + p] = known.gram[p][q];
  const std::vector<double> shares = closest_combination(gram, {known.rhs.begin(), known.rhs.begin() + m});
  for_all_unknowns(op, [&](std::ptrdiff_t from, int count) {
    const double* __restrict newest = past_.front().x.data() + from;
    double* __restrict to = x.data() + from;
    const double first = shares[0];
    for (int k = 0; k < count; ++k) to[k] = first * newest[k];
    for (int p = 1; p < m; ++p) {
      const double* __restrict newer = past_[p - 1].x.data() + from;
      const double* __restrict older = past_[p].x.data() + from;
      const double share = shares[p];
      for (int k = 0; k < count; ++k) to[k] += share * (newer[k] - older[k]);
    }
    mask_row(op, from, count, x.data());
  });
  return m * op.edge_share();
}

void History::newest_guess(const LaplaceProblem& problem, const CutCellOperator& op, std::vector<double>& x) {
  set_groups(problem, op.cells());
  for_all_unknowns(op, [&](std::ptrdiff_t from, int count) {
    std::copy_n(past_.front().x.begin() + from, count, x.begin() + from);
    mask_row(op, from, count, x.data());
  });
}

std::vector<double> closest_combination(const std::vector<double>& gram_by_rows, const std::vector<double>& products) {
  const auto m = static_cast<Eigen::Index>(products.size());
  const Eigen::Map<const Eigen::MatrixXd> gram(gram_by_rows.data(), m, m);
  const Eigen::Map<const Eigen::VectorXd> projection(products.data(), m);
  // Scaled to unit diagonal, a direction that is all but dependent on the others is left out by the pivoting.
  const Eigen::VectorXd unit = gram.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = unit.asDiagonal() * gram * unit.asDiagonal();
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver;
  solver.setThreshold(1e-10);
  solver.compute(scaled);
  const Eigen::VectorXd alpha = unit.cwiseProduct(solver.solve(unit.cwiseProduct(projection)));
  return {alpha.begin(), alpha.end()};
}

void History::remember(std::vector<double>& x, std::vector<double> body_potential) {
  Past past;
  if (past_.size() == length) {
    past = std::move(past_.back());
    past_.pop_back();
  }
  parallel::resize_in_huge_pages(past.x, x.size());
  std::swap(past.x, x);
  past.body = std::move(body_potential);
  past_.push_front(std::move(past));
}

}  // namespace lichtenberg::laplace
