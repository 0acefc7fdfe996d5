#pragma once

namespace lichtenberg::periodic {

/// Numbers that are computed with together, n at a time; anywhere in memory where doubles may be.
template <int n>
struct LanesOf {
  typedef double type __attribute__((vector_size(8 * n), aligned(8), may_alias));
};
template <int n>
using Lanes = typename LanesOf<n>::type;

template <int n>
inline Lanes<n>& lanes(double* p) {
  return *reinterpret_cast<Lanes<n>*>(p);
}
template <int n>
inline const Lanes<n>& lanes(const double* p) {
  return *reinterpret_cast<const Lanes<n>*>(p);
}

}  // namespace lichtenberg::periodic
