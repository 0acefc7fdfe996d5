#include "solvers/network/packing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "solvers/error.hpp"
#include "solvers/neighbours/pairs.hpp"

namespace lichtenberg::network {
namespace {

double height(const Point& p, const PackingWall& wall) {
  return (p[0] - wall.point[0]) * wall.normal[0] + (p[1] - wall.point[1]) * wall.normal[1] +
         (p[2] - wall.point[2]) * wall.normal[2];
}

/// Particles sorted into cubes at least as large as the largest diameter, so that pairs in contact are in neighbouring
/// cubes.
class Cells {
 public:
  explicit Cells(const ParticlePacking& packing) {
    const int n = packing.size();
    for (int axis = 0; axis < 3; ++axis) low_[axis] = high_[axis] = packing.position[0][axis];
    for (const Point& p : packing.position)
      for (int axis = 0; axis < 3; ++axis) {
        low_[axis] = std::min(low_[axis], p[axis]);
        high_[axis] = std::max(high_[axis], p[axis]);
      }
    choose_size(2 * *std::ranges::max_element(packing.radius), n);
    std::vector<int> cell(n);
    for (int i = 0; i < n; ++i) cell[i] = cell_of(packing.position[i]);
    start_.assign(std::size_t(count_[0]) * count_[1] * count_[2] + 1, 0);
    for (const int c : cell) ++start_[c + 1];
    std::partial_sum(start_.begin(), start_.end(), start_.begin());
    std::vector<int> next(start_.begin(), start_.end() - 1);
    member_.resize(n);
    for (int i = 0; i < n; ++i) {
      const Point& p = packing.position[i];
      member_[next[cell[i]]++] = {p, packing.radius[i], i};
    }
  }

  template <class Visit>
  void each_pair(const Visit& visit) const {
    for (int z = 0; z < count_[2]; ++z)
      for (int y = 0; y < count_[1]; ++y)
        for (int x = 0; x < count_[0]; ++x) pairs_of_cell(x, y, z, visit);
  }

 private:
  struct Member {
    Point x;
    double radius;
    int index;
  };

  /// Chooses the cell size: larger cells if there were more of them than particles, for widely scattered particles.
  void choose_size(double largest_diameter, int n) {
    size_ = largest_diameter;
    for (;; size_ *= 2) {
      double cells = 1;
      for (int axis = 0; axis < 3; ++axis) cells *= std::floor((high_[axis] - low_[axis]) / size_) + 1;
      if (cells <= 4.0 * n + 64) break;
    }
    for (int axis = 0; axis < 3; ++axis) count_[axis] = static_cast<int>((high_[axis] - low_[axis]) / size_) + 1;
  }
  int cell_of(const Point& p) const {
    const auto along = [&](int axis) { return static_cast<int>((p[axis] - low_[axis]) / size_); };
    return along(0) + count_[0] * (along(1) + count_[1] * along(2));
  }

  template <class Visit>
  void pairs_of_cell(int x, int y, int z, const Visit& visit) const {
    const int here = x + count_[0] * (y + count_[1] * z);
    for (int a = start_[here]; a < start_[here + 1]; ++a)
      for (int b = a + 1; b < start_[here + 1]; ++b) visit(member_[a], member_[b]);
    // Half of the neighbouring cells suffices, because the other half finds the pairs from its side.
    constexpr int half[13][3] = {{1, 0, 0},  {-1, 1, 0}, {0, 1, 0}, {1, 1, 0},  {-1, -1, 1}, {0, -1, 1}, {1, -1, 1},
                                 {-1, 0, 1}, {0, 0, 1},  {1, 0, 1}, {-1, 1, 1}, {0, 1, 1},   {1, 1, 1}};
    for (const auto& [dx, dy, dz] : half) {
      const int u = x + dx, v = y + dy, w = z + dz;
      if (u < 0 || u >= count_[0] || v < 0 || v >= count_[1] || w >= count_[2]) continue;
      const int there = u + count_[0] * (v + count_[1] * w);
      for (int a = start_[here]; a < start_[here + 1]; ++a)
        for (int b = start_[there]; b < start_[there + 1]; ++b) visit(member_[a], member_[b]);
    }
  }

  Point low_{}, high_{};
  double size_ = 0;
  std::array<int, 3> count_{};
  std::vector<int> start_;
  std::vector<Member> member_;
};

/// Finds pairs in a box with periodic sides.
std::vector<ParticleContact> periodic_pairs(const ParticlePacking& packing) {
  std::vector<double> position;
  for (const Point& p : packing.position) position.insert(position.end(), p.begin(), p.end());
  std::vector<ParticleContact> contacts;
  for (const auto [i, j] : pairs_closer_than(Spheres<3>{position, packing.radius, packing.box}, 0))
    if (const ParticleContact pair{i, j};
        distance(packing, pair) < (1 - contact_margin) * (packing.radius[i] + packing.radius[j]))
      contacts.push_back(pair);
  return contacts;
}

/// Returns the vector (m) from the first to the second particle of a contact, of nearest images.
Point between(const ParticlePacking& packing, const ParticleContact& contact) {
  const Point &a = packing.position[contact.i], &b = packing.position[contact.j];
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
  check_positive(packing.radius, "radius");
  check_positive(packing.resistivity, "resistivity");
  for (int i = 0; i < packing.size(); ++i)
    if (!std::ranges::all_of(packing.position[i], [](double x) { return std::isfinite(x); }))
      throw InputError(fmt::format("particle {} has no finite position", i));
}

Contacts find_contacts(const ParticlePacking& packing) {
  Contacts contacts;
  if (packing.position.empty()) return contacts;
  constexpr double shrink = (1 - contact_margin) * (1 - contact_margin);
  contacts.pairs.reserve(3 * packing.position.size());
  const auto take = [&](const auto& a, const auto& b) {
    const double dx = a.x[0] - b.x[0], dy = a.x[1] - b.x[1], dz = a.x[2] - b.x[2], reach = a.radius + b.radius;
    if (dx * dx + dy * dy + dz * dz < shrink * reach * reach)
      contacts.pairs.push_back({std::min(a.index, b.index), std::max(a.index, b.index)});
  };
  if (packing.box.any_periodic())
    contacts.pairs = periodic_pairs(packing);
  else
    Cells(packing).each_pair(take);
  for (std::size_t w = 0; w < packing.walls.size(); ++w)
    for (int i = 0; i < packing.size(); ++i)
      if (height(packing.position[i], packing.walls[w]) < (1 - contact_margin) * packing.radius[i])
        contacts.walls.push_back({i, static_cast<int>(w)});
  return contacts;
}

double distance(const ParticlePacking& packing, const ParticleContact& contact) {
  return distance(between(packing, contact), {});
}

ContactState contact_state(const ParticlePacking& packing, const ParticleContact& contact) {
  const double ri = packing.radius[contact.i], rj = packing.radius[contact.j];
  return contact_state(packing, distance(packing, contact), ri + rj, ri * rj / (ri + rj), false);
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
