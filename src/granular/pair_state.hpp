#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "solvers/geometry/vec.hpp"
#include "src/granular/lanes.hpp"
#include "src/model/neighbours.hpp"

namespace lichtenberg::granular {

/// Relative position and velocity of two grains, of j with respect to i. `Real` is a double, or a SIMD vector of
/// several pairs.
template <int d, class Real = double>
struct PairState {
  typename VecOf<d, Real>::type separation;  ///< r, from i to j (d0)
  typename VecOf<d, Real>::type velocity;    ///< r' (v0)
};

/// Returns the states `yes` in the lanes where the condition `which` holds, and `no` in the others.
template <int d, class Real>
LICHTENBERG_HOST_DEVICE PairState<d, Real> chosen(const MaskOf<Real>& which, const PairState<d, Real>& yes,
                                                  const PairState<d, Real>& no) {
  return {chosen<d, Real>(which, yes.separation, no.separation), chosen<d, Real>(which, yes.velocity, no.velocity)};
}

/// Advances position and momentum of a grain by a time t under a constant force. `per_mass`: 1 / mass. Position,
/// momentum and force are vectors, or one component of them.
template <class Vector, class Real>
LICHTENBERG_HOST_DEVICE void fly(Vector& position, Vector& momentum, const Vector& force, const Real& per_mass,
                                 const Real& t) {
  position += t * per_mass * (momentum + 0.5 * t * force);
  momentum += t * force;
}

/// Smallest allowed distance of two centres, in units of the sum of the radii. If centres pass through each other, the
/// direction of a contact is undefined.
inline constexpr double too_close = 0.1;

/// Returns the time at which the distance of a pair in straight relative motion r + v t falls to `reach`; infinite if
/// it never does. b = r v (scalar product), c = r^2 - reach^2 > 0 (the pair is separate), v2 = v^2.
template <class Real>
LICHTENBERG_HOST_DEVICE Real straight_onset(const Real& b, const Real& c, const Real& v2) {
  const Real root = b * b - v2 * c;
  return chosen<Real>(b < 0 && root > 0, c / (root_of(not_below<Real>(root, 0)) - b), INFINITY);
}

/// Returns the closing speed of a pair along the line of centres; negative if the grains recede.
template <int d, class Real>
LICHTENBERG_HOST_DEVICE Real closing(const PairState<d, Real>& s) {
  using std::sqrt;
  return -dot(s.separation, s.velocity) / sqrt(norm2(s.separation));
}

/// Returns the relative speed of a pair across (normal to) the line of centres.
template <int d>
LICHTENBERG_HOST_DEVICE double speed_across(const PairState<d>& s) {
  return norm(s.velocity + (closing(s) / norm(s.separation)) * s.separation);
}

/// Returns the sum of the radii of a pair (d0).
inline double reach(const Bodies& b, Pair p) { return b.radius[p.i] + b.radius[p.j]; }
/// Returns the reduced (effective) mass of a pair, m_i m_j / (m_i + m_j).
inline double reduced_mass(const Bodies& b, Pair p) { return b.mass[p.i] * b.mass[p.j] / (b.mass[p.i] + b.mass[p.j]); }

/// Returns vector i of an array [N * d].
template <int d>
Vec<d> vector_of(std::span<const double> values, int i) {
  Vec<d> v;
  for (int k = 0; k < d; ++k) v[k] = values[i * d + k];
  return v;
}

/// Returns the vector from grain i of a pair to the nearest image of grain j.
template <int d>
Vec<d> separation(const Spheres<d>& grains, Pair p) {
  return grains.box.difference(grains.centre(p.j), grains.centre(p.i));
}

/// Returns the relative position and velocity of a pair. `grains`: spheres<d>(bodies).
template <int d>
PairState<d> pair_state(const Bodies& bodies, const Spheres<d>& grains, Pair p) {
  return {separation(grains, p), vector_of<d>(bodies.momentum, p.j) / bodies.mass[p.j] -
                                     vector_of<d>(bodies.momentum, p.i) / bodies.mass[p.i]};
}

}  // namespace lichtenberg::granular
