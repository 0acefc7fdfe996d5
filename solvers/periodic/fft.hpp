#pragma once

#include <vector>

#include "solvers/periodic/lanes.hpp"

namespace lichtenberg::periodic {

/// A discrete Fourier transform of complex numbers along one axis, of `side_by_side` rows at once (Stockham's method;
/// radices 2 to 5, other primes by the definition). FFTW's measured plans do not give the same
/// bits in each run.
template <class Real>
class RowTransform {
 public:
  static constexpr int side_by_side = 64 / sizeof(Real);
  using Numbers = Lanes<side_by_side, Real>;

  explicit RowTransform(int length);

  /// Transforms re + i im with exp(-2 pi i k x / length) in place; `spare`: twice the length. With re and im exchanged
  /// it is the transform back. Not normalized.
  void apply(Numbers* re, Numbers* im, Numbers* spare) const;

 private:
  struct Pass {
    int radix, groups, stride;
    std::vector<Real> cosine, sine;            ///< of the twiddle factors, [groups][radix]
    std::vector<Real> root_cosine, root_sine;  ///< roots of unity of a radix above 5
  };
  template <int radix>
  static void apply(const Pass& pass, const Numbers* re, const Numbers* im, Numbers* to_re, Numbers* to_im);
  static void apply_any(const Pass& pass, const Numbers* re, const Numbers* im, Numbers* to_re, Numbers* to_im);

  int length_;
  std::vector<Pass> passes_;
};

/// Transposes as many rows as each has numbers.
template <class Numbers>
void transpose(Numbers* rows) {
  constexpr int n = count_of<Numbers>;
  // Each round moves a bit of a number's row to its column and one of its column to its row.
#pragma GCC unroll 4
  for (int round = 1; round < n; round *= 2) {
    Numbers turned[n];
#pragma GCC unroll 8
    for (int k = 0; k < n / 2; ++k) {
      turned[2 * k] = interleaved<false>(rows[k], rows[k + n / 2]);
      turned[2 * k + 1] = interleaved<true>(rows[k], rows[k + n / 2]);
    }
    for (int k = 0; k < n; ++k) rows[k] = turned[k];
  }
}

}  // namespace lichtenberg::periodic
