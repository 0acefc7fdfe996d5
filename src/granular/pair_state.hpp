#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "solvers/geometry/vec.hpp"
#include "src/granular/lanes.hpp"
#include "src/model/neighbours.hpp"

namespace lichtenberg::granular {

/// Relative state of two grains, of j with respect to i.
template <int d, class Real = double>
struct PairState {
  typename VecOf<d, Real>::type separation;  ///< r, from i to j (d0)
  typename VecOf<d, Real>::type velocity;    ///< r' (v0)
};

template <int d, class Real>
LICHTENBERG_HOST_DEVICE PairState<d, Real> chosen(const MaskOf<Real>& which, const PairState<d, Real>& yes,
                                                  const PairState<d, Real>& no) {
  return {chosen<d, Real>(which, yes.separation, no.separation), chosen<d, Real>(which, yes.velocity, no.velocity)};
}

/// Moves a grain through a time t under a constant force: vectors, or one component of each.
template <class Vector, class Real>
LICHTENBERG_HOST_DEVICE void fly(Vector& position, Vector& momentum, const Vector& force, const Real& per_mass,
                                 const Real& t) {
  position += t * per_mass * (momentum + 0.5 * t * force);
  momentum += t * force;
}

/// Least distance of two centres, as a part of the sum of radii: where centres pass through each other, a contact has
/// no direction.
inline constexpr double too_close = 0.1;

/// Returns the time after which a pair in straight relative motion r + v t has the distance `reach`; infinite if it
/// never has. b = r v, c = r^2 - reach^2 > 0 (the pair is apart), v2 = v^2.
template <class Real>
LICHTENBERG_HOST_DEVICE Real straight_onset(const Real& b, const Real& c, const Real& v2) {
  const Real root = b * b - v2 * c;
  return chosen<Real>(b < 0 && root > 0, c / (root_of(not_below<Real>(root, 0)) - b), INFINITY);
}

/// Returns the approach speed along the line of centres.
template <int d, class Real>
LICHTENBERG_HOST_DEVICE Real closing(const PairState<d, Real>& s) {
  using std::sqrt;
  return -dot(s.separation, s.velocity) / sqrt(norm2(s.separation));
}

/// Returns the relative speed normal to the line of centres.
template <int d>
LICHTENBERG_HOST_DEVICE double speed_across(const PairState<d>& s) {
  return norm(s.velocity + (closing(s) / norm(s.separation)) * s.separation);
}

inline double reach(const Bodies& b, Pair p) { return b.radius[p.i] + b.radius[p.j]; }
inline double reduced_mass(const Bodies& b, Pair p) { return b.mass[p.i] * b.mass[p.j] / (b.mass[p.i] + b.mass[p.j]); }

template <int d>
Vec<d> vector_of(std::span<const double> values, int i) {
  Vec<d> v;
  for (int k = 0; k < d; ++k) v[k] = values[i * d + k];
  return v;
}

/// Returns the vector from i to the nearest image of j.
template <int d>
Vec<d> separation(const Spheres<d>& grains, Pair p) {
  return grains.box.difference(grains.centre(p.j), grains.centre(p.i));
}

/// Returns the state of a pair; `grains` are the positions of the bodies.
template <int d>
PairState<d> pair_state(const Bodies& bodies, const Spheres<d>& grains, Pair p) {
  return {separation(grains, p), vector_of<d>(bodies.momentum, p.j) / bodies.mass[p.j] -
                                     vector_of<d>(bodies.momentum, p.i) / bodies.mass[p.i]};
}

}  // namespace lichtenberg::granular
