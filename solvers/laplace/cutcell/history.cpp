#include "solvers/laplace/cutcell/history.hpp"

#include <algorithm>

#include "solvers/laplace/cutcell/wavefront.hpp"
#include "solvers/parallel/huge_pages.hpp"

namespace lichtenberg::laplace {

namespace {

/// Calls entries(first slot, number of slots) for all rows of cells on the threads of the team, then for the groups. A
/// slot is the memory index of a cell.
template <class Entries>
void for_all_unknowns(const CutCellOperator& op, const Entries& entries) {
  const Layout& at = op.level().layout;
  for_each_row(op.team(), at, [&](int j) {
    for (int colour = 0; colour < 2; ++colour) entries(at.row(colour, j), at.row_length(colour, j));
  });
  entries(static_cast<std::ptrdiff_t>(op.cells()), static_cast<int>(op.size() - op.cells()));
}

/// Sets x to zero in the covered cells (inside conductors) of a row.
void mask_row(const CutCellOperator& op, std::ptrdiff_t row, int count, double* __restrict x) {
  if (row >= static_cast<std::ptrdiff_t>(op.cells())) return;
  const double* __restrict diagonal = op.level().diagonal.data();
  for (std::ptrdiff_t k = row; k < row + count; ++k) x[k] = diagonal[k] > 0 ? x[k] : 0.0;
}

}  // namespace

/// Computes the group potentials of the stored solutions for the present groups: each gets the mean of its bodies.
void SolutionHistory::set_groups(const LaplaceProblem& problem, std::size_t cells) {
  std::vector<int> members(problem.groups.size(), 0);
  for (const Body& body : problem.bodies) ++members[body.group];
  for (StoredSolution& solution : solutions_) {
    solution.x.resize(cells + problem.groups.size());
    std::fill(solution.x.begin() + cells, solution.x.end(), 0.0);
    for (std::size_t body = 0; body < problem.bodies.size(); ++body) {
      const int g = problem.bodies[body].group;
      if (problem.groups[g].floating) solution.x[cells + g] += solution.body[body] / members[g];
    }
  }
}

/// Computes `count` entries of all basis vectors from index `from` on, in a row of cells or of groups.
void SolutionHistory::form_basis(const CutCellOperator& op, std::ptrdiff_t from, int count) {
  for (int p = 0; p < static_cast<int>(solutions_.size()); ++p) {
    const double* __restrict newer = solutions_[std::max(p - 1, 0)].x.data();
    const double* __restrict older = solutions_[p].x.data();
    double* __restrict to = basis_[p].data();
    for (std::ptrdiff_t k = from; k < from + count; ++k) to[k] = p == 0 ? older[k] : newer[k] - older[k];
    mask_row(op, from, count, to);
  }
}

GuessProducts SolutionHistory::row_products(const CutCellOperator& op, const double* b, int j) {
  const Layout& at = op.level().layout;
  const auto dot = [&](const double* u, const double* v) {
    double sum = 0;
    for (int colour = 0; colour < 2; ++colour)
      sum += row_dot(at.row_length(colour, j), u + at.row(colour, j), v + at.row(colour, j));
    return sum;
  };
  GuessProducts products;
  for (int p = 0; p < static_cast<int>(solutions_.size()); ++p) {
    products.gram[p][p] = op.apply_row(j, basis_[p].data(), image_.data());
    for (int q = 0; q < p; ++q) products.gram[p][q] = dot(basis_[q].data(), image_.data());
    products.rhs[p] = dot(basis_[p].data(), b);
  }
  return products;
}

GuessProducts SolutionHistory::group_products(const CutCellOperator& op, const double* b) {
  const int groups = static_cast<int>(op.size() - op.cells());
  GuessProducts products;
  for (int p = 0; p < static_cast<int>(solutions_.size()); ++p) {
    double* image = image_.data() + op.cells();
    products.gram[p][p] = op.apply_groups(basis_[p].data(), image);
    for (int q = 0; q < p; ++q) products.gram[p][q] = row_dot(groups, basis_[q].data() + op.cells(), image);
    products.rhs[p] = row_dot(groups, basis_[p].data() + op.cells(), b + op.cells());
  }
  return products;
}

/// Computes the scalar products of the basis vectors. The basis is formed one row ahead of its products, so that all
/// vectors take one pass over memory.
GuessProducts SolutionHistory::products(const CutCellOperator& op, const std::vector<double>& b) {
  parallel::resize_in_huge_pages(image_, op.size());
  for (std::size_t p = 0; p < solutions_.size(); ++p) parallel::resize_in_huge_pages(basis_[p], op.size());
  form_basis(op, static_cast<std::ptrdiff_t>(op.cells()), static_cast<int>(op.size() - op.cells()));
  const Layout& at = op.level().layout;
  std::vector<GuessProducts> row_results(at.ny);
  wavefront(op.team(), at, 2, 0, [&](int stage, int j) {
    if (stage == 1)
      row_results[j] = row_products(op, b.data(), j);
    else
      for (int colour = 0; colour < 2; ++colour) form_basis(op, at.row(colour, j), at.row_length(colour, j));
  });
  GuessProducts all = group_products(op, b.data());
  if (!at.is_first()) all = {};
  for (const GuessProducts& row : row_results) all += row;
  add_over_slabs(at, &all.gram[0][0], sizeof(GuessProducts) / sizeof(double));
  return all;
}

double SolutionHistory::initial_guess(const LaplaceProblem& problem, const CutCellOperator& op,
                                      const std::vector<double>& b, std::vector<double>& x) {
  set_groups(problem, op.cells());
  const int m = static_cast<int>(solutions_.size());
  const Shares share = closest_shares(products(op, b), m);
  for_all_unknowns(op, [&](std::ptrdiff_t from, int count) {
    for (int p = 0; p < m; ++p) {
      double* __restrict to = x.data();
      const double* __restrict of = basis_[p].data();
      for (std::ptrdiff_t k = from; k < from + count; ++k) to[k] = share.of[p] * of[k] + (p == 0 ? 0.0 : to[k]);
    }
  });
  return m;
}

void SolutionHistory::newest_as_guess(const LaplaceProblem& problem, const CutCellOperator& op,
                                      std::vector<double>& x) {
  set_groups(problem, op.cells());
  for_all_unknowns(op, [&](std::ptrdiff_t from, int count) {
    std::copy_n(solutions_.front().x.begin() + from, count, x.begin() + from);
    mask_row(op, from, count, x.data());
  });
}

void SolutionHistory::store(std::vector<double>& x, std::vector<double> body_potential) {
  StoredSolution solution;
  if (solutions_.size() == history_length) {
    solution = std::move(solutions_.back());
    solutions_.pop_back();
  }
  parallel::resize_in_huge_pages(solution.x, x.size());
  std::swap(solution.x, x);
  solution.body = std::move(body_potential);
  solutions_.push_front(std::move(solution));
}

}  // namespace lichtenberg::laplace
