#include "src/granular/pair_list.hpp"

#include <algorithm>
#include <cmath>

#include "src/model/neighbours.hpp"

namespace lichtenberg::granular {

std::span<const Pair> PairList::pairs(const Bodies& bodies, double travel, parallel::Team& team) {
  if (!is_valid_for(bodies, travel)) search(bodies, travel, team);
  return pairs_;
}

bool PairList::is_valid_for(const Bodies& bodies, double travel) const {
  if (searched_at_.size() != bodies.position.size()) return false;
  return visit_spheres(bodies, [&]<int d>(const Spheres<d>& grains) {
    const NearestImage<d> nearest(grains.box);
    for (int i = 0; i < grains.size(); ++i) {
      const double left = reach_[i] - travel;
      double moved2 = 0;
      for (int k = i * d; k < (i + 1) * d; ++k) {
        const double moved = nearest(bodies.position[k] - searched_at_[k], k - i * d);
        moved2 += moved * moved;
      }
      if (left < 0 || moved2 > left * left) return false;
    }
    return true;
  });
}

namespace {

/// Speeds of the grains, and the speed `usual` = four times the rms speed, above which a grain gets a larger skin. In a
/// Maxwellian gas hardly one grain of 1e5 exceeds it.
struct Speeds {
  explicit Speeds(const Bodies& bodies) {
    double squares = 0;
    for (int i = 0; i < bodies.size(); ++i) {
      double sum = 0;
      for (int k = i * bodies.dimension; k < (i + 1) * bodies.dimension; ++k)
        sum += bodies.momentum[k] * bodies.momentum[k];
      speed.push_back(std::sqrt(sum) / bodies.mass[i]);
      squares += speed.back() * speed.back();
      fastest = std::max(fastest, speed.back());
    }
    usual = 4 * std::sqrt(squares / std::max(1, bodies.size()));
  }

  std::vector<double> speed;
  double fastest = 0, usual = 0;
};

double shortest_period(const Bodies& bodies) {
  double shortest = INFINITY;
  for (int k = 0; k < bodies.dimension; ++k)
    if (bodies.box.periodic(k)) shortest = std::min(shortest, bodies.box.lengths[k]);
  return shortest;
}

}  // namespace

/// Rebuilds the list. All grains get the same skin, because a collision can make any grain fast. Only grains that are
/// far faster than the others get a larger skin.
void PairList::search(const Bodies& bodies, double travel, parallel::Team& team) {
  const Speeds speeds(bodies);
  // A search beyond half of the box would find two images of one grain.
  const double radius = *std::ranges::max_element(bodies.radius), half = 0.5 * shortest_period(bodies) * (1 - 1e-9);
  const double most = std::max(0.5 * (half - range_) - radius, travel);
  const double reach = std::min(travel + move_ * radius, most);
  reach_.assign(bodies.size(), reach);
  if (speeds.fastest > speeds.usual) {
    for (int i = 0; i < bodies.size(); ++i)
      reach_[i] = std::min(reach * std::max(1.0, speeds.speed[i] / speeds.usual), most);
    pairs_ = pairs_within_reach(bodies, range_, reach_, team);
  } else {
    pairs_ = pairs_closer_than(bodies, range_ + 2 * reach, team);
  }
  searched_at_ = bodies.position;
  ++searches_;
}

}  // namespace lichtenberg::granular
