#pragma once

#include <array>
#include <type_traits>

#include "solvers/periodic/lanes.hpp"

namespace lichtenberg::periodic {

/// Cardinal B-splines of `order` (degree order - 1, as many mesh points wide), as what a place between two mesh points
/// gives to, or takes from, the points around it: the c-th of them has the weight M(t + order - 1 - c), where t is how
/// far (in spacings, 0 <= t < 1) the place lies behind the point before it and M the spline on [0, order]. So the first
/// of them is the point before the place, and the mesh as a whole lies order / 2 - 1 spacings further back than it
/// should: no sum that is spread and taken with the same weights can tell.
template <int order, class Real = double>
struct Spline {
  static_assert(order >= 3 && order <= 8);
  /// A row of weights, zeros behind the last: as wide as a vector of numbers that processors have.
  static constexpr int lanes = order <= 4 ? 4 : 8;
  using Row = Lanes<lanes, Real>;
  using Coefficients = std::array<std::array<Real, lanes>, order>;  ///< of t^d in the c-th weight: [d][c]

  /// M_n(u) = (u M_{n-1}(u) + (n - u) M_{n-1}(u - 1)) / (n - 1) for its pieces u = j + t; the c-th weight has
  /// j = order - 1 - c.
  static constexpr Coefficients weights_of() {
    std::array<std::array<double, order>, order> piece{};  // [j][d]
    piece[0][0] = 1;
    for (int n = 2; n <= order; ++n) {
      const auto lower = piece;
      for (int j = 0; j < n; ++j)
        for (int d = 0; d < n; ++d) {
          double sum = j * lower[j][d];
          if (d > 0) sum += lower[j][d - 1];
          if (j > 0) sum += (n - j) * lower[j - 1][d];
          if (j > 0 && d > 0) sum -= lower[j - 1][d - 1];
          piece[j][d] = sum / (n - 1);
        }
    }
    Coefficients weights{};
    for (int d = 0; d < order; ++d)
      for (int c = 0; c < order; ++c) weights[d][c] = static_cast<Real>(piece[order - 1 - c][d]);
    return weights;
  }
  static constexpr Coefficients slopes_of(const Coefficients& weights) {
    Coefficients slopes{};
    for (int d = 1; d < order; ++d)
      for (int c = 0; c < order; ++c) slopes[d - 1][c] = d * weights[d][c];
    return slopes;
  }
  alignas(64) static constexpr Coefficients coefficients = weights_of();
  alignas(64) static constexpr Coefficients slope_coefficients = slopes_of(coefficients);
  alignas(64) static constexpr Coefficients curvature_coefficients = slopes_of(slope_coefficients);

  static void weights(Real t, Row& row) { polynomial<order>(coefficients, t, row); }
  /// Derivatives of the weights by t.
  static void slopes(Real t, Row& row) { polynomial<order - 1>(slope_coefficients, t, row); }
  /// Second derivatives.
  static void curvatures(Real t, Row& row) { polynomial<order - 2>(curvature_coefficients, t, row); }

 private:
  template <int terms>
  static void polynomial(const Coefficients& of, Real t, Row& row) {
    row = periodic::lanes<lanes>(of[terms - 1].data());
    for (int d = terms - 2; d >= 0; --d) row = row * t + periodic::lanes<lanes>(of[d].data());
  }
};

/// Calls work(order as a constant) for an order from 4 to `most`.
template <int most, class Work>
void with_order(int order, const Work& work) {
  if (order == most) return work(std::integral_constant<int, most>{});
  if constexpr (most > 4) with_order<most - 1>(order, work);
}

}  // namespace lichtenberg::periodic
