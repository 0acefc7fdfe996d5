#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "solvers/geometry/box.hpp"
#include "solvers/neighbours/pairs.hpp"

namespace lichtenberg {

struct Scene;

/// Particles as arrays. `dimension` is 2 or 3; position[i * dimension + k] is coordinate k of particle i.
struct Bodies {
  int dimension = 2;
  std::vector<double> position;  ///< m, [N * dimension]
  std::vector<double> momentum;  ///< kg m/s, [N * dimension]
  std::vector<double> mass;      ///< kg, [N]
  std::vector<double> radius;    ///< m, [N]
  std::vector<double> charge;    ///< C, [N]; empty unless an effect needs charges
  bool fix_z = false;            ///< three dimensions: nothing moves along z
  /// Box with the periodic axes; in two dimensions front and back are unused.
  Box<3> box;
  /// Number of windings around the box, [N * dimension]; empty unless the box is periodic.
  std::vector<int> image;

  int size() const { return static_cast<int>(radius.size()); }
};

/// Returns the conductors of a scene at its first instant: positions, momenta, and masses of solid spheres, m = 4/3 pi
/// density R^3 (D 5.5.2). Positions are wrapped into a periodic domain. The bodies have no charges; `initial_charges`
/// returns these.
Bodies make_bodies(const Scene& scene);

/// Returns the conductors' charges at the start (C). The charge of a wired group is divided equally among its members;
/// the first field solve corrects the division.
std::vector<double> initial_charges(const Scene& scene);

/// Returns positions, radii, box and charges of bodies of `d` dimensions as views of their current state.
template <int d>
Spheres<d> spheres(const Bodies& bodies) {
  Box<d> box;
  for (int k = 0; k < d; ++k) box.lengths[k] = bodies.box.lengths[k];
  std::copy_n(bodies.box.sides.begin(), 2 * d, box.sides.begin());
  return {bodies.position, bodies.radius, box, bodies.charge};
}

/// Wraps bodies into a periodic box and counts the windings, so that position + image * lengths stays continuous.
void wrap(Bodies& bodies);

/// Throws InputError unless the bodies have `d` dimensions.
void check_dimension(const Bodies& bodies, int d);

/// Vector i of an array [N * dimension]; its z is 0 in two dimensions.
inline Vec3 vector_at(std::span<const double> components, int dimension, int i) {
  const double* c = components.data() + static_cast<std::size_t>(i) * dimension;
  return {c[0], c[1], dimension == 3 ? c[2] : 0};
}

/// Position (m) and velocity (m/s) of body i as vectors in space; their z is 0 in two dimensions.
inline Vec3 position_in_space(const Bodies& bodies, int i) { return vector_at(bodies.position, bodies.dimension, i); }
inline Vec3 velocity_in_space(const Bodies& bodies, int i) {
  return vector_at(bodies.momentum, bodies.dimension, i) / bodies.mass[i];
}

/// Returns the sum of m v^2 / 2 (J).
double kinetic_energy(const Bodies& bodies);

/// Position (m) and velocity (m/s) of body i. Throws InputError unless the bodies have `d` dimensions.
template <int d = 2>
Vec<d> position(const Bodies& bodies, int i) {
  check_dimension(bodies, d);
  Vec<d> p;
  for (int k = 0; k < d; ++k) p[k] = bodies.position[i * d + k];
  return p;
}
template <int d = 2>
Vec<d> velocity(const Bodies& bodies, int i) {
  check_dimension(bodies, d);
  Vec<d> p;
  for (int k = 0; k < d; ++k) p[k] = bodies.momentum[i * d + k];
  return p / bodies.mass[i];
}

}  // namespace lichtenberg
