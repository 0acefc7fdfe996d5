#pragma once

// Functions for code that computes one pair or several pairs at once. `Real` is double, or several doubles in a vector
// register (std::experimental::simd). Each lane has the arithmetic of a double.

#include <array>
#include <cmath>
#include <type_traits>

#include "solvers/geometry/vec.hpp"

namespace lichtenberg::granular {

/// Type of a comparison of two Reals: bool, or a SIMD mask with one truth value for each lane.
template <class Real>
using MaskOf = std::decay_t<decltype(Real() < Real())>;

/// Returns true if the condition holds, for a SIMD mask if it holds in any lane.
template <class Mask>
LICHTENBERG_HOST_DEVICE bool any(const Mask& which) {
  if constexpr (std::is_same_v<Mask, bool>)
    return which;
  else
    return any_of(which);
}

/// Returns `yes` in the lanes where the condition `which` holds, and `no` in the others.
template <class Real>
LICHTENBERG_HOST_DEVICE Real chosen(const MaskOf<Real>& which, const Real& yes, const Real& no) {
  if constexpr (std::is_same_v<Real, double>) {
    return which ? yes : no;
  } else {
    Real result = no;
    where(which, result) = yes;
    return result;
  }
}
/// Returns the maximum of x and `least` in each lane; NaN in x stays NaN.
template <class Real>
LICHTENBERG_HOST_DEVICE Real not_below(const Real& x, const Real& least) {
  return chosen<Real>(x < least, least, x);
}
/// Returns the minimum of x and `most` in each lane; NaN in x stays NaN.
template <class Real>
LICHTENBERG_HOST_DEVICE Real not_above(const Real& x, const Real& most) {
  return chosen<Real>(x > most, most, x);
}

/// Returns the square root of x >= 0. On a device it is computed by the faster reciprocal square root.
template <class Real>
LICHTENBERG_HOST_DEVICE Real root_of(const Real& x) {
#ifdef __CUDA_ARCH__
  return x > 0 ? x * rsqrt(x) : 0;
#else
  using std::sqrt;
  return sqrt(x);
#endif
}

/// A positive number and its reciprocal.
template <class Real>
struct WithInverse {
  Real value, inverse;
};
/// Returns the square root of x > 0 and its reciprocal. On a device both follow from the reciprocal square root.
template <class Real>
LICHTENBERG_HOST_DEVICE WithInverse<Real> root_and_inverse(const Real& x) {
#ifdef __CUDA_ARCH__
  const Real inverse = rsqrt(x);
  return {x * inverse, inverse};
#else
  const Real value = root_of(x);
  return {value, 1.0 / value};
#endif
}

/// Vectors with `d` components of several pairs: component k of all pairs is in the lanes of of[k].
template <int d, class Real>
struct LaneVec {
  std::array<Real, d> of{};

  Real& operator[](int k) { return of[k]; }
  const Real& operator[](int k) const { return of[k]; }
  LaneVec& operator+=(const LaneVec& b) { return *this = *this + b; }
  friend LaneVec operator+(const LaneVec& a, const LaneVec& b) {
    return each([&](int k) { return a[k] + b[k]; });
  }
  friend LaneVec operator-(const LaneVec& a, const LaneVec& b) {
    return each([&](int k) { return a[k] - b[k]; });
  }
  friend LaneVec operator*(const Real& s, const LaneVec& a) {
    return each([&](int k) { return s * a[k]; });
  }
  friend Real dot(const LaneVec& a, const LaneVec& b) {
    Real sum = a[0] * b[0];
    for (int k = 1; k < d; ++k) sum += a[k] * b[k];
    return sum;
  }
  friend Real norm2(const LaneVec& a) { return dot(a, a); }

  /// Returns the vector with the components component(k).
  template <class Component>
  static LaneVec each(const Component& component) {
    LaneVec v;
    for (int k = 0; k < d; ++k) v[k] = component(k);
    return v;
  }
};

/// Vector type for Real: Vec<d> for a double, LaneVec<d, Real> for a SIMD vector.
template <int d, class Real>
struct VecOf {
  using type = LaneVec<d, Real>;
};
template <int d>
struct VecOf<d, double> {
  using type = Vec<d>;
};

/// Returns the vectors `yes` in the lanes where the condition `which` holds, and `no` in the others.
template <int d, class Real>
LICHTENBERG_HOST_DEVICE typename VecOf<d, Real>::type chosen(const MaskOf<Real>& which,
                                                             const typename VecOf<d, Real>::type& yes,
                                                             const typename VecOf<d, Real>::type& no) {
  typename VecOf<d, Real>::type result;
  for (int k = 0; k < d; ++k) result[k] = chosen<Real>(which, yes[k], no[k]);
  return result;
}

}  // namespace lichtenberg::granular
