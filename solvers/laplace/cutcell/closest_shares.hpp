#pragma once

#include <cmath>

#include "solvers/geometry/host_device.hpp"

namespace lichtenberg::laplace {

/// Number of past solutions stored for the initial guess of the next solve.
constexpr int history_length = 3;

/// Scalar products of the basis vectors v_p of an initial guess. `gram` [p][q]: v_p' A v_q with the system matrix A,
/// lower triangle; `rhs` [p]: v_p' b with the right-hand side b.
struct GuessProducts {
  double gram[history_length][history_length] = {}, rhs[history_length] = {};
  LICHTENBERG_HOST_DEVICE GuessProducts& operator+=(const GuessProducts& other) {
    for (int p = 0; p < history_length; ++p) {
      rhs[p] += other.rhs[p];
      for (int q = 0; q <= p; ++q) gram[p][q] += other.gram[p][q];
    }
    return *this;
  }
};

/// Coefficients of a linear combination of basis vectors (past solutions), for the initial guess.
struct Shares {
  double of[history_length];
};

/// Computes the linear combination of m basis vectors that is closest to the solution in the energy norm (Galerkin
/// projection). It solves gram * shares = rhs by symmetric elimination, scaled to unit diagonal, with the largest pivot
/// first. Vectors whose remaining pivot is below 1e-10 (linearly dependent) get the coefficient 0.
LICHTENBERG_HOST_DEVICE inline Shares closest_shares(const GuessProducts& products, int m) {
  constexpr double dependent = 1e-10;
  double a[history_length][history_length], b[history_length], unit[history_length];
  for (int p = 0; p < m; ++p) unit[p] = products.gram[p][p] > 1e-300 ? 1 / std::sqrt(products.gram[p][p]) : 0.0;
  for (int p = 0; p < m; ++p) {
    b[p] = unit[p] * products.rhs[p];
    for (int q = 0; q < m; ++q) a[p][q] = unit[p] * unit[q] * (p > q ? products.gram[p][q] : products.gram[q][p]);
  }
  int pivot[history_length], pivots = 0;
  bool eliminated[history_length] = {};
  for (; pivots < m; ++pivots) {
    int k = -1;
    for (int p = 0; p < m; ++p)
      if (!eliminated[p] && a[p][p] > dependent && (k < 0 || a[p][p] > a[k][k])) k = p;
    if (k < 0) break;
    pivot[pivots] = k;
    eliminated[k] = true;
    for (int p = 0; p < m; ++p) {
      if (eliminated[p]) continue;
      const double ratio = a[p][k] / a[k][k];
      b[p] -= ratio * b[k];
      for (int q = 0; q < m; ++q)
        if (!eliminated[q]) a[p][q] -= ratio * a[k][q];
    }
  }
  Shares share{};
  for (int s = pivots - 1; s >= 0; --s) {
    const int k = pivot[s];
    double sum = b[k];
    for (int t = s + 1; t < pivots; ++t) sum -= a[k][pivot[t]] * share.of[pivot[t]];
    share.of[k] = sum / a[k][k];
  }
  for (int p = 0; p < m; ++p) share.of[p] *= unit[p];
  return share;
}

}  // namespace lichtenberg::laplace
