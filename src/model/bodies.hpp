#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "solvers/geometry/box.hpp"
#include "solvers/neighbours/pairs.hpp"

namespace lichtenberg {

struct Scene;

/// Positions, momenta, masses, radii and charges of N particles as arrays. position[i * dimension + k] is coordinate k
/// of particle i; `dimension` is 2 or 3. Units are SI for conductors, and the reduced units of the scene for grains.
struct Bodies {
  int dimension = 2;
  std::vector<double> position;  ///< m, [N * dimension]
  std::vector<double> momentum;  ///< kg m/s, [N * dimension]
  std::vector<double> mass;      ///< kg, [N]
  std::vector<double> radius;    ///< m, [N]
  std::vector<double> charge;    ///< C, [N]; empty unless an effect needs charges
  bool fix_z = false;            ///< true: the particles of a three-dimensional scene do not move along z
  /// Domain (m) with its periodic axes; in two dimensions its sides `front` and `back` are unused.
  Box<3> box;
  /// Number of periods by which each particle has crossed the periodic box along each axis, [N * dimension]; empty
  /// unless the box is periodic.
  std::vector<int> image;
  /// Angular velocity (1/s), [N * 3], or [N] in two dimensions; empty unless the particles rotate
  /// (Effect::set_surface).
  std::vector<double> angular_velocity{};
  std::vector<double> inertia{};  ///< moment of inertia (kg m^2), [N]; empty like angular_velocity

  int size() const { return static_cast<int>(radius.size()); }
};

/// Returns the conductors or grains of a scene at its first instant: positions wrapped into a periodic domain, momenta,
/// radii, and masses of solid spheres, m = 4/3 pi density R^3. The mass of a fixed conductor is 2^100 times as large,
/// so that no force moves it. Bodies::charge is empty; `initial_charges` returns the charges.
Bodies make_bodies(const Scene& scene);

/// Returns the charge of each conductor (C, [N]) or grain (q0, [N]) of a scene at the start. Conductors wired to one
/// group have a total charge, which is divided equally among them; the first field solve corrects the division.
std::vector<double> initial_charges(const Scene& scene);

/// Returns views of the positions, radii and charges of the bodies, with a copy of their box, as input of the pair
/// searches. `d` must be bodies.dimension.
template <int d>
Spheres<d> spheres(const Bodies& bodies) {
  Box<d> box;
  for (int k = 0; k < d; ++k) box.lengths[k] = bodies.box.lengths[k];
  std::copy_n(bodies.box.sides.begin(), 2 * d, box.sides.begin());
  return {bodies.position, bodies.radius, box, bodies.charge};
}

/// Moves bodies outside a periodic box back into it by whole periods. The periods are added to Bodies::image, so that
/// position + image * lengths is unchanged. Has no effect without periodic axes.
void wrap(Bodies& bodies);

/// Throws InputError unless the bodies have `d` dimensions.
void check_dimension(const Bodies& bodies, int d);

/// Returns vector i of `components` [N * dimension] as a vector in space; its z is 0 in two dimensions.
inline Vec3 vector_at(std::span<const double> components, int dimension, int i) {
  const double* c = components.data() + static_cast<std::size_t>(i) * dimension;
  return {c[0], c[1], dimension == 3 ? c[2] : 0};
}

/// Returns the position (m) of body i as a vector in space; its z is 0 in two dimensions.
inline Vec3 position_in_space(const Bodies& bodies, int i) { return vector_at(bodies.position, bodies.dimension, i); }
/// Returns the velocity (m/s) of body i, momentum / mass, as a vector in space; its z is 0 in two dimensions.
inline Vec3 velocity_in_space(const Bodies& bodies, int i) {
  return vector_at(bodies.momentum, bodies.dimension, i) / bodies.mass[i];
}

/// Returns the kinetic energy of all bodies, the sum of m v^2 / 2 (J; for grains in reduced units).
double kinetic_energy(const Bodies& bodies);

/// Returns the position (m) of body i. Throws InputError unless the bodies have `d` dimensions.
template <int d = 2>
Vec<d> position(const Bodies& bodies, int i) {
  check_dimension(bodies, d);
  Vec<d> p;
  for (int k = 0; k < d; ++k) p[k] = bodies.position[i * d + k];
  return p;
}
/// Returns the velocity (m/s) of body i, momentum / mass. Throws InputError unless the bodies have `d` dimensions.
template <int d = 2>
Vec<d> velocity(const Bodies& bodies, int i) {
  check_dimension(bodies, d);
  Vec<d> p;
  for (int k = 0; k < d; ++k) p[k] = bodies.momentum[i * d + k];
  return p / bodies.mass[i];
}

}  // namespace lichtenberg
