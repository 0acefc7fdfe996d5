#pragma once

#include <string>
#include <vector>

#include "solvers/network/network.hpp"

namespace lichtenberg::network {

/// A flat wall: the packing lies on the side to which the normal points.
struct PackingWall {
  std::string name;
  Point point{}, normal{};  ///< m; of length 1
};

/// Spheres, or disks in the plane z = 0, between walls.
struct ParticlePacking {
  std::vector<Point> position;
  std::vector<double> radius;  ///< m
  std::vector<PackingWall> walls;
  /// [N], or empty for all alike: by what a particle's material resists more than the model's parameters say.
  std::vector<double> resistivity;

  int size() const { return static_cast<int>(position.size()); }
  double resistivity_of(int particle) const { return resistivity.empty() ? 1 : resistivity[particle]; }
};

/// Throws InputError for radii and resistivities that are not positive and finite, and positions that are not finite.
void check(const ParticlePacking& packing);

/// Two particles that touch, i < j.
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

/// Two particles touch if their distance is less than (1 - margin)(r_i + r_j), a particle and a wall if the centre's
/// height above the wall is less than (1 - margin) r. Rattlers creep towards a distance of r_i + r_j from below, and a
/// contact without a force is none: that is what the margin is for.
constexpr double contact_margin = 1e-9;

/// All of them, by cells of the size of the largest particle; the work grows with the number of particles.
Contacts find_contacts(const ParticlePacking& packing);

/// Where two particles touch: it divides the line of centres as their radii; where one touches a wall: the foot of the
/// perpendicular.
Point contact_point(const ParticlePacking& packing, const ParticleContact& contact);
Point contact_point(const ParticlePacking& packing, const ParticleWallContact& contact);

}  // namespace lichtenberg::network
