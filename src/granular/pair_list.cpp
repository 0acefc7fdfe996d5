#include "src/granular/pair_list.hpp"

#include <algorithm>
#include <cmath>

#include "src/model/neighbours.hpp"

namespace lichtenberg::granular {

std::span<const Pair> PairList::pairs(const Bodies& bodies, double travel, parallel::Team& team) {
  if (!holds(bodies, travel)) search(bodies, travel, team);
  return pairs_;
}

bool PairList::holds(const Bodies& bodies, double travel) const {
  if (searched_at_.size() != bodies.position.size()) return false;
  return visit_spheres(bodies, [&]<int d>(const Spheres<d>& grains) {
    const Spheres<d> then{searched_at_, bodies.radius, grains.box};
    for (int i = 0; i < grains.size(); ++i) {
      const double left = reach_[i] - travel;
      if (left < 0 || norm2(grains.box.difference(grains.place(i), then.place(i))) > left * left) return false;
    }
    return true;
  });
}

/// A list lives as long as its grains stay within their reaches: a part of a radius for all, and for each as far as it
/// flies while a typical one moves by `move_` radii.
void PairList::search(const Bodies& bodies, double travel, parallel::Team& team) {
  const int d = bodies.dimension;
  const auto speed = [&](int i) {
    double sum = 0;
    for (int k = i * d; k < (i + 1) * d; ++k) sum += bodies.momentum[k] * bodies.momentum[k];
    return std::sqrt(sum) / bodies.mass[i];
  };
  double squares = 0;
  for (int i = 0; i < bodies.size(); ++i) squares += speed(i) * speed(i);
  const double typical = std::sqrt(squares / std::max(1, bodies.size()));
  const double radius = *std::ranges::max_element(bodies.radius);
  const double lifetime = typical > 0 ? move_ * radius / typical : 0;
  // Far below half a box, beyond which a search would meet two images of one grain.
  double shortest = INFINITY;
  for (int k = 0; k < d; ++k)
    if (bodies.box.periodic(k)) shortest = std::min(shortest, bodies.box.lengths[k]);
  const double most = std::max(0.1 * shortest, travel);
  reach_.resize(bodies.size());
  for (int i = 0; i < bodies.size(); ++i) reach_[i] = std::min(travel + 0.1 * radius + speed(i) * lifetime, most);
  pairs_ = pairs_within_reach(bodies, range_, reach_, team);
  searched_at_ = bodies.position;
  ++searches_;
}

}  // namespace lichtenberg::granular
