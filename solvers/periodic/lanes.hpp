#pragma once

namespace lichtenberg::periodic {

/// Numbers that are computed with together, n at a time; anywhere in memory where one of them may be. Which
/// instructions that takes is the compiler's affair: it knows what the processor has that it compiles for.
template <int n, class Real = double>
struct LanesOf {
  typedef Real type __attribute__((vector_size(sizeof(Real) * n), aligned(alignof(Real)), may_alias));
};
template <int n, class Real = double>
using Lanes = typename LanesOf<n, Real>::type;

template <int n, class Real>
inline Lanes<n, Real>& lanes(Real* p) {
  return *reinterpret_cast<Lanes<n, Real>*>(p);
}
template <int n, class Real>
inline const Lanes<n, Real>& lanes(const Real* p) {
  return *reinterpret_cast<const Lanes<n, Real>*>(p);
}

/// The sums of four times four numbers, adjacent ones first.
template <class Four>
Four totals(const Four& a, const Four& b, const Four& c, const Four& d) {
  const Four ab = __builtin_shufflevector(a, b, 0, 4, 2, 6) + __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const Four cd = __builtin_shufflevector(c, d, 0, 4, 2, 6) + __builtin_shufflevector(c, d, 1, 5, 3, 7);
  return __builtin_shufflevector(ab, cd, 0, 1, 4, 5) + __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
}

}  // namespace lichtenberg::periodic
