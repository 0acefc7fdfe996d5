#include "solvers/network/star_mesh.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "solvers/parallel/ranges.hpp"

namespace lichtenberg::network {
namespace {

using Block = Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>>;

constexpr int worth_products = 64;  ///< Number of rows from which products are faster than loops

/// Adds the mesh of star k to the columns from ... to - 1, down to row `rows` - 1.
void spread(double* g, int m, int k, int from, int to, int rows) {
  const double* star = g + std::size_t(k) * m;
  for (int j = from; j < to; ++j) {
    const double share = star[j] / star[k];
    if (share == 0) continue;
    double* column = g + std::size_t(j) * m;
    for (int i = j + 1; i < rows; ++i) column[i] += share * star[i];
  }
}

/// Stores the sum of star k, down to row `rows` - 1, on the diagonal.
void sum_star(double* g, int m, int k, int rows, double rest) {
  double* star = g + std::size_t(k) * m;
  for (int i = k + 1; i < rows; ++i) rest += star[i];
  star[k] = rest;
}

/// Dense network of m nodes, whose first nodes are eliminated.
class Dense {
 public:
  Dense(double* g, int m, parallel::Team& team) : g_(g), m_(m), team_(team) {}

  /// Eliminates the stars begin ... end - 1. Their columns are complete then, later columns do not change.
  void eliminate(int begin, int end) {
    constexpr int panel = 48;  // Columns that stay in the cache
    if (end - begin <= panel) return eliminate_panel(begin, end);
    const int middle = begin + (end - begin + 2 * panel - 1) / (2 * panel) * panel;
    eliminate(begin, middle);
    add_meshes(begin, middle, end);
    eliminate(middle, end);
  }

  /// Adds the meshes of the stars begin ... end - 1 to the columns end ... last - 1.
  void add_meshes(int begin, int end, int last) {
    const int rows = m_ - end;
    roots_.resize(rows, end - begin);
    parallel::for_each_range<strip>(rows, team_, [&](int first, int next) {
      for (int k = begin; k < end; ++k)
        roots_.col(k - begin).segment(first, next - first) =
            block(end + first, k, next - first, 1) / std::sqrt(g_[std::size_t(k) * (m_ + 1)]);
    });
    parallel::for_each_range<strip>(last - end, team_, [&](int first, int next) {
      const int count = next - first;
      const auto own = roots_.middleRows(first, count);
      block(end + first, end + first, count, count).selfadjointView<Eigen::Lower>().rankUpdate(own);
      if (next < rows)
        block(end + next, end + first, rows - next, count).noalias() +=
            roots_.bottomRows(rows - next) * own.transpose();
    });
  }

 private:
  static constexpr int strip = 128;  ///< Rows or columns of a task

  Block block(int row, int column, int rows, int columns) const {
    return {g_ + std::size_t(column) * m_ + row, rows, columns, Eigen::OuterStride<>(m_)};
  }

  /// Eliminates a few stars. The rows below `end` change linearly with those of the panel. Their sum is therefore one
  /// more row of the panel, and s_k is a sum of positive numbers. The rows follow from g_rj += sum_{k < j} g_rk
  /// share_kj, where both signs are reversed, because Eigen's solution subtracts.
  void eliminate_panel(int begin, int end) {
    const int width = end - begin, rest = m_ - end;
    Eigen::VectorXd below(width);
    for (int k = 0; k < width; ++k) below[k] = block(end, begin + k, rest, 1).sum();
    share_.setZero(width, width);
    for (int k = begin; k < end; ++k) {
      sum_star(g_, m_, k, end, below[k - begin]);
      const double* star = g_ + std::size_t(k) * m_;
      for (int j = k + 1; j < end; ++j) {
        share_(k - begin, j - begin) = -star[j] / star[k];
        below[j - begin] += star[j] / star[k] * below[k - begin];
      }
      spread(g_, m_, k, k + 1, end, end);
    }
    parallel::for_each_range<strip>(rest, team_, [&](int first, int next) {
      Block rows = block(end + first, begin, next - first, width);
      share_.triangularView<Eigen::UnitUpper>().solveInPlace<Eigen::OnTheRight>(rows);
    });
  }

  double* g_;
  int m_;
  parallel::Team& team_;
  Eigen::MatrixXd share_, roots_;
};

}  // namespace

void eliminate_stars(double* g, int m, int stars, parallel::Team& team) {
  constexpr int together = 256;  // Stars of a product: more of them make it faster, and its operands larger
  Dense dense(g, m, team);
  int begin = 0;
  for (int end = 0; begin < stars && m - begin >= worth_products; begin = end) {
    end = std::min(begin + together, stars);
    dense.eliminate(begin, end);
    dense.add_meshes(begin, end, m);
  }
  for (int k = begin; k < stars; ++k) {
    sum_star(g, m, k, m, 0);
    spread(g, m, k, k + 1, m, m);
  }
}

}  // namespace lichtenberg::network
