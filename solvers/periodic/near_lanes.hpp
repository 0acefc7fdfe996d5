#pragma once

#include <cmath>
#include <limits>

#include "solvers/periodic/columns.hpp"
#include "solvers/periodic/lanes.hpp"

#ifdef __AVX__
#include <immintrin.h>
#endif

// SIMD vectors of the near part, as wide as the processor's registers. In builds for repeatable results they have the
// width of AVX2's, and there are no hardware estimates, because those of Intel and AMD differ.
#if defined(__AVX512F__) && !defined(LICHTENBERG_REPEATABLE)
#define LICHTENBERG_NEAR_LANES_OF_AVX512
#endif
namespace lichtenberg::periodic {

/// Bytes of a SIMD register.
#ifdef LICHTENBERG_NEAR_LANES_OF_AVX512
constexpr int bytes_wide = 64;
#else
constexpr int bytes_wide = 32;
#endif
/// Numbers in a SIMD register.
template <class Real>
constexpr int width = bytes_wide / sizeof(Real);
/// SIMD register of real numbers.
template <class Real>
using Many = Lanes<width<Real>, Real>;
/// SIMD vector of differences of fixed-point coordinates, with as many numbers as Many.
template <class Real>
using Differences = Lanes<width<Real>, Difference<Real>>;
template <class Real>
using Eight = Lanes<8, Real>;
template <class Real>
using EightDifferences = Lanes<8, Difference<Real>>;

/// Returns the coordinates from `at` on minus `from`, of nearest images: unsigned numbers wrap at the period.
template <int count, class Real>
Lanes<count, Difference<Real>> differences(const Coordinate<Real>* at, Coordinate<Real> from) {
  return reinterpret_cast<Lanes<count, Difference<Real>>>(lanes<count>(at) - from);
}
/// Length of a box in units of fixed-point coordinates.
template <class Real>
constexpr Real whole_box = sizeof(Real) == 4 ? 0x1p32 : 0x1p64;

/// Improves an estimate y of 1 / sqrt(x) by one Newton step.
template <class Real>
[[gnu::always_inline]] inline Many<Real> improved(const Many<Real>& y, const Many<Real>& x) {
  constexpr Real half = 0.5, three_halves = 1.5;
  return y * (three_halves - half * x * y * y);
}

/// Computes 1 / sqrt(x) to nearly full precision, by a hardware estimate and Newton steps where the processor has the
/// estimate. In builds for repeatable results, square root and quotient are rounded correctly.
[[gnu::always_inline]] inline Many<float> inverse_sqrt(const Many<float>& x) {
#ifdef LICHTENBERG_NEAR_LANES_OF_AVX512
  return improved<float>(reinterpret_cast<Many<float>>(_mm512_rsqrt14_ps(reinterpret_cast<__m512>(x))), x);
#elif defined(__AVX__) && defined(LICHTENBERG_REPEATABLE)
  return 1 / reinterpret_cast<Many<float>>(_mm256_sqrt_ps(reinterpret_cast<__m256>(x)));
#elif defined(__AVX__)
  return improved<float>(reinterpret_cast<Many<float>>(_mm256_rsqrt_ps(reinterpret_cast<__m256>(x))), x);
#else
  Many<float> y;
  for (int k = 0; k < width<float>; ++k) y[k] = 1 / std::sqrt(x[k]);
  return y;
#endif
}
[[gnu::always_inline]] inline Many<double> inverse_sqrt(const Many<double>& x) {
#ifdef LICHTENBERG_NEAR_LANES_OF_AVX512
  const auto y = reinterpret_cast<Many<double>>(_mm512_rsqrt14_pd(reinterpret_cast<__m512d>(x)));
  return improved<double>(improved<double>(y, x), x);
#elif defined(__AVX__) && defined(LICHTENBERG_REPEATABLE)
  return 1 / reinterpret_cast<Many<double>>(_mm256_sqrt_pd(reinterpret_cast<__m256d>(x)));
#else
  Many<double> y;
  for (int k = 0; k < width<double>; ++k) y[k] = 1 / std::sqrt(x[k]);
  return y;
#endif
}

/// Returns the magnitude of each number.
template <class Real>
Many<Real> magnitude(const Many<Real>& x) {
  return reinterpret_cast<Many<Real>>(reinterpret_cast<Differences<Real>>(x) &
                                      std::numeric_limits<Difference<Real>>::max());
}

/// Stores the selected numbers of `x` (those whose bit is set in `bits`) consecutively at `to` (compress). May write
/// undefined values behind them.
template <class Real>
void store_selected(const Many<Real>& x, unsigned bits, Real* to) {
#ifdef LICHTENBERG_NEAR_LANES_OF_AVX512
  if constexpr (sizeof(Real) == 4)
    _mm512_storeu_ps(to, _mm512_maskz_compress_ps(static_cast<__mmask16>(bits), reinterpret_cast<__m512>(x)));
  else
    _mm512_storeu_pd(to, _mm512_maskz_compress_pd(static_cast<__mmask8>(bits), reinterpret_cast<__m512d>(x)));
#else
  for (int k = 0; k < width<Real>; ++k) {
    *to = x[k];
    to += bits >> k & 1;
  }
#endif
}

/// Returns a bit mask of the numbers of x that are below 1.
template <class Real>
unsigned below_one(const Many<Real>& x) {
#ifdef LICHTENBERG_NEAR_LANES_OF_AVX512
  if constexpr (sizeof(Real) == 4)
    return _mm512_cmp_ps_mask(reinterpret_cast<__m512>(x), _mm512_set1_ps(1), _CMP_LT_OQ);
  else
    return _mm512_cmp_pd_mask(reinterpret_cast<__m512d>(x), _mm512_set1_pd(1), _CMP_LT_OQ);
#else
  unsigned bits = 0;
  for (int k = 0; k < width<Real>; ++k) bits |= static_cast<unsigned>(x[k] < 1) << k;
  return bits;
#endif
}

/// Returns a SIMD vector of the numbers 0, 1, 2, ...
template <class Numbers>
Numbers ascending() {
  Numbers numbers;
  for (int k = 0; k < count_of<Numbers>; ++k) numbers[k] = k;
  return numbers;
}

/// Reduces a SIMD vector to four sums: each is the sum of every fourth number.
template <class Vector>
auto quarters_of(const Vector& of) {
  if constexpr (count_of<Vector> == 4)
    return of;
  else
    return quarters_of(low_half(of) + high_half(of));
}

/// Scatters results of several sources: for each k below `count`, adds the k-th numbers of the four vectors to the four
/// elements from sums[4 * number[k]] on.
template <class Real>
[[gnu::always_inline]] inline void add_lanes(const Many<Real> (&of)[4], const Difference<Real>* number, int count,
                                             Real* sums) {
  constexpr int n = width<Real>;
  alignas(64) Real together[4 * n];
  const Many<Real> low[2] = {interleaved<false>(of[0], of[2]), interleaved<false>(of[1], of[3])};
  const Many<Real> high[2] = {interleaved<true>(of[0], of[2]), interleaved<true>(of[1], of[3])};
  lanes<n>(together) = interleaved<false>(low[0], low[1]);
  lanes<n>(together + n) = interleaved<true>(low[0], low[1]);
  lanes<n>(together + 2 * n) = interleaved<false>(high[0], high[1]);
  lanes<n>(together + 3 * n) = interleaved<true>(high[0], high[1]);
  for (int k = 0; k < count; ++k) lanes<4>(&sums[4 * number[k]]) += lanes<4>(&together[4 * k]);
}

}  // namespace lichtenberg::periodic
