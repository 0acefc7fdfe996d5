#include "solvers/network/star_mesh.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace lichtenberg::network {
namespace {

using Block = Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>>;

constexpr int worth_a_product = 24;  ///< Number of remaining rows from which products are faster than loops

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

/// Elimination of the stars begin ... end - 1 at once, by products of matrices. The rows below `end` change linearly
/// with those of the panel. Their sum is therefore one more row of the panel, and s_k is a sum of positive numbers.
class Panel {
 public:
  Panel(double* g, int m, int begin, int end, parallel::Team& team)
      : g_(g), m_(m), begin_(begin), end_(end), width_(end - begin), rest_(m - end), team_(team) {}

  void eliminate() {
    factorize();
    roots_.resize(rest_, width_);
    team_.for_each(strips(), [&](int k) { finish_rows(k * strip, std::min(rest_, (k + 1) * strip)); });
    team_.for_each(strips(), [&](int k) { update_columns(k * strip, std::min(rest_, (k + 1) * strip)); });
  }

 private:
  static constexpr int strip = 192;  ///< Rows or columns of a task
  int strips() const { return (rest_ + strip - 1) / strip; }
  Block block(int row, int column, int rows, int columns) const {
    return {g_ + std::size_t(column) * m_ + row, rows, columns, Eigen::OuterStride<>(m_)};
  }

  void factorize() {
    Eigen::VectorXd below(width_);
    for (int k = 0; k < width_; ++k) below[k] = block(end_, begin_ + k, rest_, 1).sum();
    share_.setZero(width_, width_);
    scale_.resize(width_);
    for (int k = begin_; k < end_; ++k) {
      sum_star(g_, m_, k, end_, below[k - begin_]);
      const double* star = g_ + std::size_t(k) * m_;
      scale_[k - begin_] = 1 / std::sqrt(star[k]);
      for (int j = k + 1; j < end_; ++j) {
        share_(k - begin_, j - begin_) = -star[j] / star[k];
        below[j - begin_] += star[j] / star[k] * below[k - begin_];
      }
      spread(g_, m_, k, k + 1, end_, end_);
    }
  }
  /// Adds the stars of the panel to its rows below: g_rj += sum_{k < j} g_rk share_kj, with both signs reversed, as
  /// Eigen's solution subtracts.
  void finish_rows(int first, int last) {
    Block rows = block(end_ + first, begin_, last - first, width_);
    share_.triangularView<Eigen::UnitUpper>().solveInPlace<Eigen::OnTheRight>(rows);
    roots_.middleRows(first, last - first).noalias() = rows * scale_.asDiagonal();
  }
  void update_columns(int first, int last) {
    const auto own = roots_.middleRows(first, last - first);
    block(end_ + first, end_ + first, last - first, last - first).selfadjointView<Eigen::Lower>().rankUpdate(own);
    if (last < rest_)
      block(end_ + last, end_ + first, rest_ - last, last - first).noalias() +=
          roots_.bottomRows(rest_ - last) * own.transpose();
  }

  double* g_;
  int m_, begin_, end_, width_, rest_;
  parallel::Team& team_;
  Eigen::MatrixXd share_, roots_;
  Eigen::VectorXd scale_;
};

}  // namespace

void eliminate_stars(double* g, int m, int stars, parallel::Team& team) {
  const int block = m < 768 ? 48 : 96;  // Number of columns that stay in the cache during their elimination
  for (int begin = 0; begin < stars; begin += block) {
    const int end = std::min(begin + block, stars);
    if (m - end >= worth_a_product && end - begin >= 4) {
      Panel(g, m, begin, end, team).eliminate();
      continue;
    }
    for (int k = begin; k < end; ++k) {
      sum_star(g, m, k, m, 0);
      spread(g, m, k, k + 1, m, m);
    }
  }
}

}  // namespace lichtenberg::network
