#pragma once

#include <functional>
#include <string>
#include <vector>

#include "solvers/geometry/box.hpp"
#include "solvers/network/network.hpp"
#include "solvers/network/resistor.hpp"
#include "solvers/parallel/team.hpp"

namespace lichtenberg::network {

/// Flat wall of a packing. The particles are on the side to which the normal points.
struct PackingWall {
  std::string name;
  Point point{}, normal{};  ///< Point on the wall (m); unit normal
};

/// Packing of conducting spheres, or of disks in the plane z = 0, between walls.
struct ParticlePacking {
  std::vector<Point> position;  ///< Centre of each particle (m)
  std::vector<double> radius;   ///< Radius of each particle (m)
  std::vector<PackingWall> walls;
  /// Resistivity of each particle, [N], relative to the model's parameters; empty: 1 for all.
  std::vector<double> resistivity;
  Box<3> box{};  ///< Only periodic axes count: across them the nearest images touch
  /// Returns the force (N) of a contact from the distance (m) and the distance without overlap (m): between centres the
  /// sum of radii, to a wall the radius. Empty: forces are not known.
  std::function<double(double distance, double reach)> force{};

  int size() const { return static_cast<int>(position.size()); }
  double resistivity_of(int particle) const { return resistivity.empty() ? 1 : resistivity[particle]; }
};

/// Checks a packing. Throws InputError if it has no particles, if a radius or resistivity is not positive and finite,
/// or if a position is not finite.
void check(const ParticlePacking& packing);

/// Contact of two particles, by their indices i < j.
struct ParticleContact {
  int i = 0, j = 0;
};
/// Contact of a particle with a wall, by their indices.
struct ParticleWallContact {
  int particle = 0, wall = 0;
};
/// All contacts of a packing, between particles and with walls.
struct Contacts {
  std::vector<ParticleContact> pairs;      ///< Contacts between particles
  std::vector<ParticleWallContact> walls;  ///< Contacts with walls
};

/// Relative margin of the contact criterion. Two particles are in contact if their distance is less than (1 -
/// margin)(r_i + r_j), with their radii r. A particle touches a wall if the distance of its centre from the wall is
/// less than (1 - margin) r. The distance of a rattler (particle without load) from its neighbours approaches r_i + r_j
/// from below; the margin excludes such contacts without a force.
constexpr double contact_margin = 1e-9;

/// Returns the distance (m) of the centres of two particles, of nearest images.
double distance(const ParticlePacking& packing, const ParticleContact& contact);

/// Returns overlap, force and effective radius of a contact.
ContactState contact_state(const ParticlePacking& packing, const ParticleContact& contact);
/// Returns the state of a contact whose centres have a known distance (m).
ContactState contact_state(const ParticlePacking& packing, const ParticleContact& contact, double distance);
ContactState contact_state(const ParticlePacking& packing, const ParticleWallContact& contact);

/// Returns 2 if all particles are in the plane z = 0, otherwise 3.
int dimension(const ParticlePacking& packing);

/// Finds all contacts of a packing, between particles and with walls, by the criterion of contact_margin. Pairs
/// near to each other in space are so in the list. Throws InputError if a periodic box is so short that two images of a
/// particle could touch another one. The threads of `team` do not affect the result.
Contacts find_contacts(const ParticlePacking& packing, parallel::Team& team = parallel::Team::single());

/// Returns the contact point (m) of two particles, which divides the line of centres in proportion to the radii. Across
/// a periodic side it is the image next to the particle `seen_from`, one of the two.
Point contact_point(const ParticlePacking& packing, const ParticleContact& contact, int seen_from);
/// Returns the contact point (m) of two particles next to the first of them.
inline Point contact_point(const ParticlePacking& packing, const ParticleContact& contact) {
  return contact_point(packing, contact, contact.i);
}
/// Returns the contact point (m) of a particle with a wall: the foot of the perpendicular from the centre to the wall.
Point contact_point(const ParticlePacking& packing, const ParticleWallContact& contact);

}  // namespace lichtenberg::network
