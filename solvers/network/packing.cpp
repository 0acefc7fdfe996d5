#include "solvers/network/packing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "solvers/error.hpp"
#include "solvers/neighbours/pairs.hpp"
#include "solvers/network/spatial_order.hpp"
#include "solvers/parallel/ranges.hpp"

namespace lichtenberg::network {
namespace {

constexpr double farthest = 1e100;  ///< m; squares and cubes of distances are finite

double height(const Point& p, const PackingWall& wall) {
  return (p[0] - wall.point[0]) * wall.normal[0] + (p[1] - wall.point[1]) * wall.normal[1] +
         (p[2] - wall.point[2]) * wall.normal[2];
}

/// Finds the pairs of particles in contact with a search in d dimensions, which sees the particles in spatial order.
template <int d>
std::vector<ParticleContact> contacts_of_pairs(const ParticlePacking& packing, parallel::Team& team) {
  const std::vector<int> order = spatial_order(packing.position, team);
  std::vector<double> position(d * order.size()), radius(order.size());
  parallel::for_each_range(order.size(), team, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      std::copy_n(packing.position[order[k]].begin(), d, position.begin() + static_cast<std::ptrdiff_t>(d * k));
      radius[k] = packing.radius[order[k]];
    }
  });
  Box<d> box;
  for (int k = 0; k < d; ++k) box.lengths[k] = packing.box.lengths[k];
  std::copy_n(packing.box.sides.begin(), 2 * d, box.sides.begin());
  const Spheres<d> spheres{position, radius, box};
  const NearestImage<d> nearest(box);
  std::vector<ParticleContact> contacts;
  const std::vector<Pair> pairs = pairs_closer_than(spheres, 0, team);
  contacts.reserve(pairs.size());
  for (const auto [a, b] : pairs) {
    double squared = 0;
    for (int k = 0; k < d; ++k)
      squared += std::pow(nearest(position[std::size_t(a) * d + k] - position[std::size_t(b) * d + k], k), 2);
    const double within = (1 - contact_margin) * (radius[a] + radius[b]);
    if (squared < within * within) contacts.push_back({std::min(order[a], order[b]), std::max(order[a], order[b])});
  }
  return contacts;
}

/// Returns the vector (m) from the first to the second particle of a contact, of nearest images.
Point between(const ParticlePacking& packing, const ParticleContact& contact) {
  const Point &a = packing.position[contact.i], &b = packing.position[contact.j];
  if (!packing.box.any_periodic()) return {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
  const NearestImage<3> nearest(packing.box);
  return {nearest(b[0] - a[0], 0), nearest(b[1] - a[1], 1), nearest(b[2] - a[2], 2)};
}

ContactState contact_state(const ParticlePacking& packing, double distance, double reach, double effective_radius,
                           bool wall) {
  const double force = packing.force ? packing.force(distance, reach) : NAN;
  return {.overlap = reach - distance, .force = force, .radius = effective_radius, .wall = wall};
}

void check_positive(const std::vector<double>& values, const std::string& what) {
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!(values[i] > 0) || !std::isfinite(values[i]))
      throw InputError(fmt::format("particle {} has {} {:g}: it must be greater than 0", i, what, values[i]));
}

}  // namespace

void check(const ParticlePacking& packing) {
  if (packing.position.empty()) throw InputError("the packing has no particles");
  if (packing.radius.size() != packing.position.size())
    throw InputError(
        fmt::format("the packing has {} positions, but {} radii", packing.position.size(), packing.radius.size()));
  check_positive(packing.radius, "radius");
  check_positive(packing.resistivity, "resistivity");
  for (int i = 0; i < packing.size(); ++i)
    if (!std::ranges::all_of(packing.position[i], [](double x) { return std::abs(x) < farthest; }))
      throw InputError(fmt::format("particle {} has no position within {:g} m", i, farthest));
}

int dimension(const ParticlePacking& packing) {
  return std::ranges::any_of(packing.position, [](const Point& p) { return p[2] != 0; }) ? 3 : 2;
}

Contacts find_contacts(const ParticlePacking& packing, parallel::Team& team) {
  Contacts contacts;
  if (packing.position.empty()) return contacts;
  contacts.pairs = dimension(packing) == 2 && !packing.box.periodic(2) ? contacts_of_pairs<2>(packing, team)
                                                                       : contacts_of_pairs<3>(packing, team);
  for (std::size_t w = 0; w < packing.walls.size(); ++w)
    for (int i = 0; i < packing.size(); ++i)
      if (height(packing.position[i], packing.walls[w]) < (1 - contact_margin) * packing.radius[i])
        contacts.walls.push_back({i, static_cast<int>(w)});
  return contacts;
}

double distance(const ParticlePacking& packing, const ParticleContact& contact) {
  return distance(between(packing, contact), {});
}

ContactState contact_state(const ParticlePacking& packing, const ParticleContact& contact, double distance) {
  const double ri = packing.radius[contact.i], rj = packing.radius[contact.j];
  return contact_state(packing, distance, ri + rj, ri * rj / (ri + rj), false);
}
ContactState contact_state(const ParticlePacking& packing, const ParticleContact& contact) {
  return contact_state(packing, contact, distance(packing, contact));
}

ContactState contact_state(const ParticlePacking& packing, const ParticleWallContact& contact) {
  const double radius = packing.radius[contact.particle];
  return contact_state(packing, height(packing.position[contact.particle], packing.walls[contact.wall]), radius, radius,
                       true);
}

Point contact_point(const ParticlePacking& packing, const ParticleContact& contact, int seen_from) {
  const Point &a = packing.position[contact.i], &b = packing.position[contact.j],
              separation = between(packing, contact);
  const double t = packing.radius[contact.i] / (packing.radius[contact.i] + packing.radius[contact.j]);
  Point point;
  for (int axis = 0; axis < 3; ++axis) {
    const double period = seen_from == contact.j ? b[axis] - a[axis] - separation[axis] : 0;
    point[axis] = a[axis] + t * separation[axis] + period;
  }
  return point;
}

Point contact_point(const ParticlePacking& packing, const ParticleWallContact& contact) {
  const Point& p = packing.position[contact.particle];
  const PackingWall& wall = packing.walls[contact.wall];
  const double h = height(p, wall);
  return {p[0] - h * wall.normal[0], p[1] - h * wall.normal[1], p[2] - h * wall.normal[2]};
}

}  // namespace lichtenberg::network
