#pragma once

#include <type_traits>
#include <vector>

#include "solvers/geometry/host_device.hpp"
#include "solvers/parallel/unroll.hpp"
#include "solvers/periodic/cloud.hpp"
#include "solvers/periodic/sources.hpp"

// Near part of two charges or dipoles with clouds: B_0 = 1/r less the cloud's potential, and B_(n+1) = -B_n' / r. The
// cloud's potential and its derivatives are polynomials in r^2 (docs/numerics/ewald.md).
namespace lichtenberg::periodic {

/// Computes a polynomial that approximates the cloud's potential within the cut-off, for single precision: coefficients
/// of powers of x = 2 (r / cutoff)^2 - 1.
/// The criterion is the squared change of the force between unit charges, integrated over the ball of the cut-off. The
/// degree is the lowest from 4 for which it is at most 0.09 of Cloud::neglected, or 30 if none suffices. At 0.09 the
/// rms error of the near part grows by 4 %, and that of a sum with an equal mesh error by 2 %.
std::vector<double> cloud_polynomial(const Cloud& cloud);
/// Computes a polynomial that approximates the cloud's potential within the cut-off, for double precision and devices:
/// coefficients of powers of x = 2 (r / cutoff)^2 - 1. The degree is even, and 30 if no lower one suffices. It suffices
/// if the neglected terms change the force by less than a tenth of the root mean square of Cloud::neglected. For kinds
/// with dipoles the same holds for derivatives of the force.
std::vector<double> cloud_polynomial(const Cloud& cloud, Kind kind);

/// Checks a cut-off, and returns it. Throws InputError if a side of the box is not positive, or if the cut-off exceeds
/// half of a side.
double checked_cutoff(Vec3 lengths, double cutoff);

/// Coefficients of the near kernels B_0 = 1/r minus the cloud's potential, and B_(n+1) = -B_n' / r, up to B_3. With x =
/// square_factor r^2 - 1, B_k is (2k - 1)!! / r^(2k + 1) + sum_n term[k][n] x^n. Unneeded terms are 0.
template <class Real, int most>
struct NearKernels {
  int terms = 0;
  Real square_factor = 0;
  Real term[4][most] = {};

  NearKernels() = default;
  /// Computes the coefficients of B_0 to B_3. `cloud`: coefficients of cloud_polynomial(), at most `most` of them;
  /// `by_square`: the value of `square_factor`.
  NearKernels(std::vector<double> cloud, double by_square)
      : terms(static_cast<int>(cloud.size())), square_factor(static_cast<Real>(by_square)) {
    for (double& coefficient : cloud) coefficient = -coefficient;
    for (auto& kernel : term) {
      for (std::size_t n = 0; n < cloud.size(); ++n) kernel[n] = static_cast<Real>(cloud[n]);
      for (std::size_t n = 1; n < cloud.size(); ++n)
        cloud[n - 1] = -(2 * by_square * static_cast<double>(n)) * cloud[n];
      if (!cloud.empty()) cloud.pop_back();
    }
  }
};

/// Computes the near kernels B_first to B_last (screened Coulomb interaction) at n distances r, given their squares
/// `r2` and inverses `over` (1/r). b[k] are the values of B_k. `terms`: number of polynomial terms, or a compile-time
/// constant for which loops are unrolled. Number is a scalar or a SIMD vector.
template <int first, int last, int n, class Number, class Terms, class Table>
LICHTENBERG_HOST_DEVICE inline void screened(const Table& table, Terms terms, const Number (&r2)[n],
                                             const Number (&over)[n], Number (&b)[4][n]) {
  Number x[n];
  for (int m = 0; m < n; ++m) x[m] = table.square_factor * r2[m] - 1;
  for (int k = first; k <= last; ++k)
    for (int m = 0; m < n; ++m) b[k][m] = Number{} + table.term[k][terms - 1];
  if constexpr (std::is_same_v<Terms, int>) {
    for (int t = terms - 2; t >= 0; --t)
      for (int k = first; k <= last; ++k)
        for (int m = 0; m < n; ++m) b[k][m] = b[k][m] * x[m] + table.term[k][t];
  } else {
    LICHTENBERG_UNROLL(32)
    for (int t = terms - 2; t >= 0; --t)
      for (int k = first; k <= last; ++k)
        for (int m = 0; m < n; ++m) b[k][m] = b[k][m] * x[m] + table.term[k][t];
  }
  for (int m = 0; m < n; ++m) {
    const Number over2 = over[m] * over[m], over3 = over2 * over[m];
    if constexpr (first == 0) b[0][m] = over[m] + b[0][m];
    if constexpr (last >= 1) b[1][m] = over3 + b[1][m];
    if constexpr (last >= 2) b[2][m] = 3 * over3 * over2 + b[2][m];
    if constexpr (last >= 3) b[3][m] = 15 * over3 * over2 * over2 + b[3][m];
  }
}

}  // namespace lichtenberg::periodic
