#pragma once

#include <string>
#include <vector>

#include "solvers/network/network.hpp"

namespace lichtenberg::network {

/// Flat wall: the packing lies on the side to which the normal points.
struct PackingWall {
  std::string name;
  Point point{}, normal{};  ///< Point on the wall (m); unit normal
};

/// Spheres, or disks in the plane z = 0, between walls.
struct ParticlePacking {
  std::vector<Point> position;
  std::vector<double> radius;  ///< Radius of each particle (m)
  std::vector<PackingWall> walls;
  /// Resistivity of each particle, [N], relative to the model's parameters; empty: 1 for all.
  std::vector<double> resistivity;

  int size() const { return static_cast<int>(position.size()); }
  double resistivity_of(int particle) const { return resistivity.empty() ? 1 : resistivity[particle]; }
};

/// Throws InputError for radii and resistivities that are not positive and finite, and positions that are not finite.
void check(const ParticlePacking& packing);

/// Two particles in contact, i < j.
struct ParticleContact {
  int i = 0, j = 0;
};
struct ParticleWallContact {
  int particle = 0, wall = 0;
};
struct Contacts {
  std::vector<ParticleContact> pairs;
  std::vector<ParticleWallContact> walls;
};

/// Relative margin of the contact criterion: two particles touch if their distance is less than (1 - margin)(r_i +
/// r_j). A particle touches a wall if its centre is less than (1 - margin) r above it. The distance of rattlers
/// approaches r_i + r_j from below; the margin excludes such contacts without a force.
constexpr double contact_margin = 1e-9;

/// Finds all contacts, by cells of the size of the largest particle; the work grows with the number of particles.
Contacts find_contacts(const ParticlePacking& packing);

/// Returns the contact point of two particles, which divides the line of centres in proportion to the radii.
Point contact_point(const ParticlePacking& packing, const ParticleContact& contact);
/// Returns the contact point of a particle with a wall: the foot of the perpendicular from the centre.
Point contact_point(const ParticlePacking& packing, const ParticleWallContact& contact);

}  // namespace lichtenberg::network
