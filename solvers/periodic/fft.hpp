#pragma once

#include <vector>

#include "solvers/lanes.hpp"

namespace lichtenberg::periodic {
using namespace simd;

/// Fast Fourier transform (FFT) of complex numbers along one axis, for `rows_at_once` rows at once by SIMD: Stockham's
/// method with radices 2 to 5. Larger prime factors are transformed by the definition. FFTW is not used because its
/// measured plans do not give identical bits in each run.
template <class Real>
class RowTransform {
 public:
  static constexpr int rows_at_once = 64 / sizeof(Real);
  using Numbers = Lanes<rows_at_once, Real>;

  /// Prepares a transform of rows of this length.
  explicit RowTransform(int length);

  /// Transforms re + i im in place with the kernel exp(-2 pi i k x / length). With re and im exchanged it is the
  /// inverse transform. Neither is normalized. `spare`: scratch memory of twice the length.
  void apply(Numbers* re, Numbers* im, Numbers* spare) const;

 private:
  struct Pass {
    int radix, groups, stride;
    std::vector<Real> cosine, sine;            ///< Twiddle factors, [groups][radix]
    std::vector<Real> root_cosine, root_sine;  ///< Roots of unity, for a radix above 5
  };
  template <int radix>
  static void apply(const Pass& pass, const Numbers* re, const Numbers* im, Numbers* to_re, Numbers* to_im);
  static void apply_any(const Pass& pass, const Numbers* re, const Numbers* im, Numbers* to_re, Numbers* to_im);

  int length_;
  std::vector<Pass> passes_;
};

/// Transposes a square block of numbers in place: n rows, each a SIMD vector of n numbers.
template <class Numbers>
void transpose(Numbers* rows) {
  constexpr int n = count_of<Numbers>;
  // Each round exchanges one bit of the row index with one bit of the column index.
#pragma GCC unroll 4
  for (int round = 1; round < n; round *= 2) {
    Numbers exchanged[n];
#pragma GCC unroll 8
    for (int k = 0; k < n / 2; ++k) {
      exchanged[2 * k] = interleaved<false>(rows[k], rows[k + n / 2]);
      exchanged[2 * k + 1] = interleaved<true>(rows[k], rows[k + n / 2]);
    }
    for (int k = 0; k < n; ++k) rows[k] = exchanged[k];
  }
}

}  // namespace lichtenberg::periodic
