#pragma once

#include <type_traits>
#include <utility>

/// SIMD vectors.
namespace lichtenberg::simd {

// In builds for repeatable results, vectors have the width of AVX2's registers on all processors.
#if defined(__AVX512F__) && !defined(LICHTENBERG_REPEATABLE)
#define LICHTENBERG_LANES_OF_AVX512
/// Bytes of a SIMD register.
constexpr int bytes_wide = 64;
#else
constexpr int bytes_wide = 32;
#endif

/// SIMD vector type of n numbers, with the alignment of a single number. The compiler chooses the instructions for its
/// target processor.
template <int n, class Real = double>
struct LanesOf {
  typedef Real type __attribute__((vector_size(sizeof(Real) * n), aligned(alignof(Real)), may_alias));
};
/// SIMD vector of n numbers.
template <int n, class Real = double>
using Lanes = typename LanesOf<n, Real>::type;

/// Returns a reference to the n numbers from p on as a SIMD vector.
template <int n, class Real>
inline Lanes<n, Real>& lanes(Real* p) {
  return *reinterpret_cast<Lanes<n, Real>*>(p);
}
template <int n, class Real>
inline const Lanes<n, Real>& lanes(const Real* p) {
  return *reinterpret_cast<const Lanes<n, Real>*>(p);
}

/// Type of the numbers of a SIMD vector.
template <class Vector>
using NumberOf = std::remove_cvref_t<decltype(Vector{}[0])>;
/// Number of numbers in a SIMD vector.
template <class Vector>
constexpr int count_of = sizeof(Vector) / sizeof(NumberOf<Vector>);

/// Returns the first half of a SIMD vector's numbers.
template <class Vector>
[[gnu::always_inline]] inline auto low_half(const Vector& of) {
  return [&]<int... k>(std::integer_sequence<int, k...>) {
    return Lanes<sizeof...(k), NumberOf<Vector>>(__builtin_shufflevector(of, of, k...));
  }
  (std::make_integer_sequence<int, count_of<Vector> / 2>());
}
/// Returns the second half of a SIMD vector's numbers.
template <class Vector>
[[gnu::always_inline]] inline auto high_half(const Vector& of) {
  return [&]<int... k>(std::integer_sequence<int, k...>) {
    return Lanes<sizeof...(k), NumberOf<Vector>>(__builtin_shufflevector(of, of, (k + int(sizeof...(k)))...));
  }
  (std::make_integer_sequence<int, count_of<Vector> / 2>());
}
/// Concatenates two SIMD vectors.
template <class Vector>
[[gnu::always_inline]] inline auto joined(const Vector& low, const Vector& high) {
  return [&]<int... k>(std::integer_sequence<int, k...>) {
    return Lanes<sizeof...(k), NumberOf<Vector>>(__builtin_shufflevector(low, high, k...));
  }
  (std::make_integer_sequence<int, 2 * count_of<Vector>>());
}
/// Interleaves the lower (or upper) halves of two SIMD vectors: returns a0 b0 a1 b1 ...
template <bool upper, class Vector>
[[gnu::always_inline]] inline Vector interleaved(const Vector& a, const Vector& b) {
  constexpr int n = count_of<Vector>;
  return [&]<int... k>(std::integer_sequence<int, k...>) {
    return Vector(__builtin_shufflevector(a, b, (k / 2 + (upper ? n / 2 : 0) + (k % 2 == 0 ? 0 : n))...));
  }
  (std::make_integer_sequence<int, n>());
}

template <int n, class Real>
struct PackOf;
/// SIMD vector of n numbers: one vector, or two halves if it exceeds a register. GCC keeps a vector wider than a
/// register in memory.
template <int n, class Real>
using Pack = typename PackOf<n, Real>::type;

/// SIMD vector of n numbers as two halves. A single number converts to n equal ones.
template <int n, class Real>
struct Twin {
  using Half = Pack<n / 2, Real>;
  Half low, high;

  Twin() = default;
  Twin(const Half& first, const Half& second) : low(first), high(second) {}
  Twin(Real each) : low(Half{} + each), high(Half{} + each) {}
  Real operator[](int k) const { return k < n / 2 ? low[k] : high[k - n / 2]; }
  Real& operator[](int k) { return reinterpret_cast<Real*>(this)[k]; }
  friend Twin operator+(const Twin& a, const Twin& b) { return {a.low + b.low, a.high + b.high}; }
  friend Twin operator-(const Twin& a, const Twin& b) { return {a.low - b.low, a.high - b.high}; }
  friend Twin operator*(const Twin& a, const Twin& b) { return {a.low * b.low, a.high * b.high}; }
  friend Twin operator/(const Twin& a, const Twin& b) { return {a.low / b.low, a.high / b.high}; }
  friend Twin operator-(const Twin& a) { return {-a.low, -a.high}; }
  Twin& operator+=(const Twin& b) { return *this = *this + b; }
  Twin& operator-=(const Twin& b) { return *this = *this - b; }
  Twin& operator*=(const Twin& b) { return *this = *this * b; }
};
template <int n, class Real>
struct PackOf
    : std::conditional_t<n * sizeof(Real) <= bytes_wide, LanesOf<n, Real>, std::type_identity<Twin<n, Real>>> {};

/// Returns a reference to the numbers of a Pack from p on.
template <class P, class Real>
inline P& pack_at(Real* p) {
  return *reinterpret_cast<P*>(p);
}
template <class P, class Real>
inline const P& pack_at(const Real* p) {
  return *reinterpret_cast<const P*>(p);
}

template <int n, class Real>
Pack<n / 2, Real> low_half(const Twin<n, Real>& of) {
  return of.low;
}
template <int n, class Real>
Pack<n / 2, Real> high_half(const Twin<n, Real>& of) {
  return of.high;
}
/// Makes a Pack from its two halves.
template <class P, class Half>
[[gnu::always_inline]] inline P packed(const Half& low, const Half& high) {
  if constexpr (std::is_class_v<P>)
    return {low, high};
  else
    return joined(low, high);
}

/// Computes the horizontal sums of four SIMD vectors of four numbers, as one vector. Adjacent numbers are added first.
template <class Four>
Four totals(const Four& a, const Four& b, const Four& c, const Four& d) {
  const Four ab = __builtin_shufflevector(a, b, 0, 4, 2, 6) + __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const Four cd = __builtin_shufflevector(c, d, 0, 4, 2, 6) + __builtin_shufflevector(c, d, 1, 5, 3, 7);
  return __builtin_shufflevector(ab, cd, 0, 1, 4, 5) + __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
}

}  // namespace lichtenberg::simd
