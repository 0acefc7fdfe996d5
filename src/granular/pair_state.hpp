#pragma once

#include <algorithm>
#include <cmath>

#include "solvers/geometry/vec.hpp"
#include "src/model/neighbours.hpp"

namespace lichtenberg::granular {

/// Two grains at one instant, j as seen from i.
template <int d>
struct PairState {
  Vec<d> apart;     ///< r, from i to j
  Vec<d> velocity;  ///< r'
};

/// The speed at which they come closer along the line of centres.
template <int d>
double closing(const PairState<d>& s) {
  return -dot(s.apart, s.velocity) / norm(s.apart);
}

/// Their speed across it.
template <int d>
double speed_across(const PairState<d>& s) {
  return norm(s.velocity + (closing(s) / norm(s.apart)) * s.apart);
}

/// The largest speed of a grain.
inline double fastest(const Bodies& b) {
  double most = 0;
  for (int i = 0; i < b.size(); ++i) {
    double sum = 0;
    for (int k = i * b.dimension; k < (i + 1) * b.dimension; ++k) sum += b.momentum[k] * b.momentum[k];
    most = std::max(most, std::sqrt(sum) / b.mass[i]);
  }
  return most;
}

inline double reach(const Bodies& b, Pair p) { return b.radius[p.i] + b.radius[p.j]; }
inline double reduced_mass(const Bodies& b, Pair p) { return b.mass[p.i] * b.mass[p.j] / (b.mass[p.i] + b.mass[p.j]); }

template <int d>
Vec<d> vector_of(std::span<const double> values, int i) {
  Vec<d> v;
  for (int k = 0; k < d; ++k) v[k] = values[i * d + k];
  return v;
}

/// From i to the nearest image of j.
template <int d>
Vec<d> apart(const Spheres<d>& grains, Pair p) {
  return grains.box.difference(grains.place(p.j), grains.place(p.i));
}

/// `grains` are the bodies' places.
template <int d>
PairState<d> seen(const Bodies& bodies, const Spheres<d>& grains, Pair p) {
  return {apart(grains, p), vector_of<d>(bodies.momentum, p.j) / bodies.mass[p.j] -
                                vector_of<d>(bodies.momentum, p.i) / bodies.mass[p.i]};
}

}  // namespace lichtenberg::granular
