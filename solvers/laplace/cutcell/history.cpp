#include "solvers/laplace/cutcell/history.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstring>

#include "solvers/laplace/cutcell/wavefront.hpp"

namespace lichtenberg::laplace {

namespace {

/// Cells whose equations other geometries do not share: beside and just inside a surface, at electrode sides.
std::vector<std::int32_t> edge_cells(const Level& level) {
  std::vector<std::int32_t> edge(level.rim.begin(), level.rim.end());
  for (const FluidLink& link : level.links) edge.push_back(static_cast<std::int32_t>(link.cell));
  for (const SideLink& link : level.side_links)
    if (link.cell >= 0) edge.push_back(static_cast<std::int32_t>(link.cell));
  return edge;
}

/// Indices of the marks that are not 0, of which there are few.
void find_marked(const std::uint8_t* mark, int count, std::vector<std::int32_t>& index) {
  index.clear();
  constexpr int width = sizeof(std::uint64_t);
  for (int k = 0; k < count; k += width) {
    std::uint64_t several = 0;
    std::memcpy(&several, mark + k, std::min(width, count - k));
    if (several == 0) continue;
    for (int l = k; l < std::min(k + width, count); ++l)
      if (mark[l] > 0) index.push_back(l);
  }
}

}  // namespace

void History::clear() {
  past_.clear();
  edges_.clear();
}

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

void History::count_edges(const std::vector<std::int32_t>& edge, int change) {
  for (const std::int32_t cell : edge) edges_[cell] = static_cast<std::uint8_t>(edges_[cell] + change);
}

/// The newest solution and successive differences are the basis: nearly orthogonal where the solutions are nearly
/// parallel. `e` and `image` hold the solutions and what A makes of them, and anything beyond those there are.
void History::Products::add(const Values& e, const Values& image, double b) {
  Values basis = e, basis_image = image;
  for (int p = 1; p < length; ++p) {
    basis[p] = e[p - 1] - e[p];
    basis_image[p] = image[p - 1] - image[p];
  }
  for (int p = 0; p < length; ++p) {
    for (int q = 0; q <= p; ++q) gram[p][q] += basis[p] * basis_image[q];
    rhs[p] += basis[p] * b;
  }
}

void History::Products::add(const Products& other) {
  for (int p = 0; p < length; ++p) {
    for (int q = 0; q <= p; ++q) gram[p][q] += other.gram[p][q];
    rhs[p] += other.rhs[p];
  }
  cells += other.cells;
}

History::Products History::row_products(const CutCellOperator& op, const double* b, int j) const {
  const Level& level = op.level();
  const Layout& at = level.layout;
  const int m = static_cast<int>(past_.size());
  std::array<const double*, length> x{};
  for (int q = 0; q < length; ++q) x[q] = past_[std::min(q, m - 1)].x.data();
  Products products;
  thread_local std::vector<Values> image;
  thread_local std::vector<std::int32_t> active;
  for (int colour = 0; colour < 2; ++colour) {
    const std::ptrdiff_t row = at.row(colour, j), other = 1 - colour;
    const std::ptrdiff_t beside = at.row(other, j) + Layout::parity(colour, j) - row;
    const std::ptrdiff_t below = at.row(other, j - 1) - row, above = at.row(other, j + 1) - row;
    image.resize(at.stride);
    find_marked(&edges_[row], at.row_length(colour, j), active);
    std::erase_if(active, [&](std::int32_t k) { return level.diagonal[row + k] == 0; });
    for (const std::int32_t k : active) {
      const std::ptrdiff_t cell = row + k;
      for (int q = 0; q < length; ++q) image[k][q] = level.diagonal[cell] * x[q][cell];
      for (const std::ptrdiff_t neighbour : {cell + beside - 1, cell + beside, cell + below, cell + above}) {
        const double open = level.diagonal[neighbour] > 0 ? 1.0 : 0.0;
        for (int q = 0; q < length; ++q) image[k][q] -= open * x[q][neighbour];
      }
    }
    for (int q = 0; q < m; ++q)
      op.links().for_linked_cells(colour, j, past_[q].x.data() + op.cells(),
                                  [&](std::int32_t cell, double flux) { image[cell - row][q] -= flux; });
    for (const std::int32_t k : active) {
      Values e{};
      for (int q = 0; q < length; ++q) e[q] = x[q][row + k];
      products.add(e, image[k], b[row + k]);
    }
    products.cells += static_cast<long>(active.size());
  }
  return products;
}

History::Products History::products(const CutCellOperator& op, const std::vector<double>& b) const {
  const Layout& at = op.level().layout;
  std::vector<Products> of_row(at.ny);
  for_each_row(op.team(), at, [&](int j) { of_row[j] = row_products(op, b.data(), j); });
  Products all;
  for (const Products& row : of_row) all.add(row);

  const int m = static_cast<int>(past_.size());
  const std::size_t groups = op.size() - op.cells();
  std::vector<std::vector<double>> image(m, std::vector<double>(groups));
  for (int q = 0; q < m; ++q) op.apply_groups(past_[q].x.data(), image[q].data());
  for (std::size_t g = 0; g < groups; ++g) {
    Values e{}, of_group{};
    for (int q = 0; q < m; ++q) {
      e[q] = past_[q].x[op.cells() + g];
      of_group[q] = image[q][g];
    }
    all.add(e, of_group, b[op.cells() + g]);
  }
  return all;
}

/// Of each of the m solutions in the combination closest to the new one.
History::Values History::shares(const Products& known, int m) {
  std::vector<double> gram(m * m);
  for (int p = 0; p < m; ++p)
    for (int q = 0; q <= p; ++q) gram[p * m + q] = gram[q * m + p] = known.gram[p][q];
  const std::vector<double> alpha = closest_combination(gram, {known.rhs.begin(), known.rhs.begin() + m});
  Values share{};
  for (int p = 0; p < m; ++p) {
    share[p] += p == 0 ? alpha[p] : -alpha[p];
    if (p > 0) share[p - 1] += alpha[p];
  }
  return share;
}

double History::first_guess(const LaplaceProblem& problem, const CutCellOperator& op, const std::vector<double>& b,
                            std::vector<double>& x) {
  if (past_.empty()) {
    std::fill(x.begin(), x.end(), 0.0);
    return 0;
  }
  set_groups(problem, op.cells());
  const int m = static_cast<int>(past_.size());
  Products known;
  Values share{1};  // of each solution; faces that are open in part have no edges to tell from the rest
  if (op.level().east.empty()) {
    const std::vector<std::int32_t> present = edge_cells(op.level());
    count_edges(present, 1);
    known = products(op, b);
    count_edges(present, -1);
    share = shares(known, m);
  }

  const Layout& at = op.level().layout;
  const auto combine = [&](std::size_t from, std::size_t to) {
    for (std::size_t k = from; k < to; ++k) x[k] = share[0] * past_[0].x[k];
    for (int p = 1; p < m; ++p)
      for (std::size_t k = from; k < to; ++k) x[k] += share[p] * past_[p].x[k];
  };
  for_each_row(op.team(), at, [&](int j) {
    for (int colour = 0; colour < 2; ++colour) {
      const std::ptrdiff_t row = at.row(colour, j), end = row + at.row_length(colour, j);
      combine(row, end);
      const double* diagonal = op.level().diagonal.data();
      for (std::ptrdiff_t k = row; k < end; ++k) x[k] = diagonal[k] > 0 ? x[k] : 0.0;
    }
  });
  combine(op.cells(), op.size());
  return static_cast<double>(m) * known.cells / (static_cast<double>(at.nx) * at.ny);
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

void History::remember(const Level& level, std::vector<double>& x, std::vector<double> body_potential) {
  Past past;
  if (past_.size() == length) {
    past = std::move(past_.back());
    past_.pop_back();
    count_edges(past.edge, -1);
  }
  edges_.resize(level.layout.size());
  past.x.resize(x.size());
  std::swap(past.x, x);
  past.body = std::move(body_potential);
  past.edge = edge_cells(level);
  count_edges(past.edge, 1);
  for (const std::ptrdiff_t slot : level.covered) past.x[slot] = past.body[level.cover[slot].body()];
  past_.push_front(std::move(past));
}

}  // namespace lichtenberg::laplace
