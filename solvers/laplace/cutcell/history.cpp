#include "solvers/laplace/cutcell/history.hpp"

#include <algorithm>
#include <functional>

#include "solvers/laplace/cutcell/wavefront.hpp"
#include "solvers/parallel/huge_pages.hpp"

namespace lichtenberg::laplace {

namespace {

/// Returns the mean potential of each floating group's bodies (bodies with one potential); 0 for groups of given
/// potential. `body` [bodies].
std::vector<double> group_means(const LaplaceProblem& problem, const std::vector<double>& body) {
  std::vector<int> members(problem.groups.size(), 0);
  for (const Body& each : problem.bodies) ++members[each.group];
  std::vector<double> mean(problem.groups.size(), 0.0);
  for (std::size_t k = 0; k < body.size(); ++k)
    if (const int g = problem.bodies[k].group; problem.groups[g].floating) mean[g] += body[k] / members[g];
  return mean;
}

/// Calls effect(first slot, number of slots) for both colours of row j. A slot is the memory index of a cell.
template <class Effect>
void for_each_colour(const Layout& at, int j, const Effect& effect) {
  for (int colour = 0; colour < 2; ++colour) effect(at.row(colour, j), at.row_length(colour, j));
}

/// Copies a row of n cells; covered cells (inside conductors), which have no diagonal, become zero.
void copy_masked(int n, const double* __restrict diagonal, const double* __restrict from, double* __restrict to) {
  for (int k = 0; k < n; ++k) to[k] = diagonal[k] > 0 ? from[k] : 0.0;
}

}  // namespace

/// Computes the potentials of the present groups in the basis: each gets the mean of its bodies.
void SolutionHistory::set_groups(const LaplaceProblem& problem, std::size_t cells, double* x_group) {
  std::vector<double> newer = group_means(problem, solutions_[0].body);
  std::ranges::copy(newer, x_group);
  for (int p = 0; p < differences(); ++p) {
    parallel::resize_in_huge_pages(difference_[p].cell, cells);
    const std::vector<double> older = group_means(problem, solutions_[p + 1].body);
    difference_[p].group.resize(newer.size());
    std::ranges::transform(newer, older, difference_[p].group.begin(), std::minus());
    newer = older;
  }
}

/// Computes row j of the basis: x becomes the newest solution. All are zero in covered cells.
void SolutionHistory::form_basis(const CutCellOperator& op, int j, double* x) {
  for_each_colour(op.level().layout, j, [&](std::ptrdiff_t row, int n) {
    const double* __restrict diagonal = op.level().diagonal.data() + row;
    copy_masked(n, diagonal, solutions_[0].x.data() + row, x + row);
    for (int p = 0; p < differences(); ++p) {
      const double* __restrict newer = solutions_[p].x.data() + row;
      const double* __restrict older = solutions_[p + 1].x.data() + row;
      float* __restrict to = difference_[p].cell.data() + row;
      for (int k = 0; k < n; ++k) to[k] = diagonal[k] > 0 ? static_cast<float>(newer[k] - older[k]) : 0.0f;
    }
  });
}

/// Computes the scalar products of row j, without the links to groups.
GuessProducts SolutionHistory::row_products(const CutCellOperator& op, const double* b, const double* x, int j) const {
  const Layout& at = op.level().layout;
  thread_local std::vector<double> memory;
  if (static_cast<std::ptrdiff_t>(memory.size()) < at.stride) memory.resize(at.stride);
  double* image = memory.data();
  GuessProducts products;
  for (int colour = 0; colour < 2; ++colour) {
    const std::ptrdiff_t row = at.row(colour, j);
    const int n = at.row_length(colour, j);
    op.apply_cells(colour, j, x, image);
    products.gram[0][0] += row_dot(n, image, x + row);
    products.rhs[0] += row_dot(n, b + row, x + row);
    for (int p = 0; p < differences(); ++p) {
      const float* difference = difference_[p].cell.data();
      products.gram[p + 1][0] += row_dot(n, image, difference + row);
      products.rhs[p + 1] += row_dot(n, b + row, difference + row);
    }
    for (int p = 0; p < differences(); ++p) {
      op.apply_cells(colour, j, difference_[p].cell.data(), image);
      for (int q = p; q < differences(); ++q)
        products.gram[q + 1][p + 1] += row_dot(n, image, difference_[q].cell.data() + row);
    }
  }
  return products;
}

/// Computes the groups' part of the scalar products, and that of all links between groups and cells.
GuessProducts SolutionHistory::group_products(const CutCellOperator& op, const double* b, const double* x) const {
  const int groups = static_cast<int>(op.size() - op.cells()), count = differences() + 1;
  std::array<std::vector<double>, history_length> flux, image;
  std::array<const double*, history_length> potential{x + op.cells()};
  for (int p = 0; p < count; ++p) {
    flux[p].resize(groups);
    image[p].resize(groups);
    if (p > 0) potential[p] = difference_[p - 1].group.data();
    if (p == 0) {
      op.add_cell_fluxes(x, flux[p].data());
      op.apply_groups(x, potential[p], image[p].data());
    } else {
      op.add_cell_fluxes(difference_[p - 1].cell.data(), flux[p].data());
      op.apply_groups(difference_[p - 1].cell.data(), potential[p], image[p].data());
    }
  }
  GuessProducts products;
  for (int p = 0; p < count; ++p) {
    products.rhs[p] = row_dot(groups, b + op.cells(), potential[p]);
    for (int q = 0; q <= p; ++q)
      products.gram[p][q] =
          row_dot(groups, image[q].data(), potential[p]) - row_dot(groups, flux[p].data(), potential[q]);
  }
  return products;
}

/// Computes the scalar products of the basis vectors. The basis is formed one row ahead of its products, so that all
/// vectors take one pass over memory.
GuessProducts SolutionHistory::products(const CutCellOperator& op, const double* b, double* x) {
  const Layout& at = op.level().layout;
  std::vector<GuessProducts> row_results(at.ny);
  wavefront(op.team(), at, 2, [&](int stage, int j) {
    if (stage == 0)
      form_basis(op, j, x);
    else
      row_results[j] = row_products(op, b, x, j);
  });
  GuessProducts all = group_products(op, b, x);
  for (const GuessProducts& row : row_results) all += row;
  return all;
}

double SolutionHistory::initial_guess(const LaplaceProblem& problem, const CutCellOperator& op,
                                      const std::vector<double>& b, std::vector<double>& x) {
  set_groups(problem, op.cells(), x.data() + op.cells());
  const Shares share = closest_shares(products(op, b.data(), x.data()), differences() + 1);
  const auto scale = [&](double* __restrict to, int n) {
    for (int k = 0; k < n; ++k) to[k] *= share.of[0];
  };
  const auto add = [](double* __restrict to, const auto* __restrict difference, int n, double factor) {
    for (int k = 0; k < n; ++k) to[k] += factor * difference[k];
  };
  for_each_row(op.team(), op.level().layout, [&](int j) {
    for_each_colour(op.level().layout, j, [&](std::ptrdiff_t row, int n) {
      scale(&x[row], n);
      for (int p = 0; p < differences(); ++p) add(&x[row], &difference_[p].cell[row], n, share.of[p + 1]);
    });
  });
  const int groups = static_cast<int>(op.size() - op.cells());
  scale(&x[op.cells()], groups);
  for (int p = 0; p < differences(); ++p) add(&x[op.cells()], difference_[p].group.data(), groups, share.of[p + 1]);
  return differences() + 1;
}

void SolutionHistory::newest_as_guess(const LaplaceProblem& problem, const CutCellOperator& op,
                                      std::vector<double>& x) {
  std::ranges::copy(group_means(problem, solutions_.front().body), x.begin() + static_cast<std::ptrdiff_t>(op.cells()));
  for_each_row(op.team(), op.level().layout, [&](int j) {
    for_each_colour(op.level().layout, j, [&](std::ptrdiff_t row, int n) {
      copy_masked(n, &op.level().diagonal[row], &solutions_.front().x[row], &x[row]);
    });
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
