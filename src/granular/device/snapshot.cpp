#include "src/granular/device/snapshot.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace lichtenberg::granular::device {
namespace {

void store_grains(const Snapshot& from, Checkpoint& to) {
  const std::size_t n = from.grains.size();
  std::vector<double>&position = to.reals["position"], &momentum = to.reals["momentum"];
  std::vector<std::int64_t>& image = to.integers["image"];
  position.resize(3 * n), momentum.resize(3 * n), image.resize(3 * n);
  for (std::size_t i = 0; i < n; ++i) {
    const GrainRecord& g = from.grains[i];
    for (int k = 0; k < 3; ++k) position[3 * i + k] = g.position[k], momentum[3 * i + k] = g.momentum[k];
    image[3 * i] = g.image.x, image[3 * i + 1] = g.image.y, image[3 * i + 2] = g.image.z;
  }
  const auto by_grain = [&](auto& values, auto GrainRecord::*member) {
    values.resize(n);
    std::ranges::transform(from.grains, values.begin(), [&](const GrainRecord& g) { return g.*member; });
  };
  if (from.charged) by_grain(to.reals["charge"], &GrainRecord::charge);
  if (from.exchanges) by_grain(to.integers["effects.charge_exchange.collisions"], &GrainRecord::collisions);
}

void store_rotation(const RoughSnapshot& from, Checkpoint& to) {
  if (!from.rotates) return;
  std::vector<double>& spins = to.reals["angular_velocity"];
  spins.clear();
  for (const RoughRecord& one : from.grains) spins.insert(spins.end(), {one.spin.x, one.spin.y, one.spin.z});
}

/// Stores the contacts with walls, as RoughMotion::save().
void store_walls(const RoughSnapshot& from, Checkpoint& to) {
  const auto grains = static_cast<std::int64_t>(from.grains.size());
  std::vector<std::int64_t>& walls = to.integers["wall_contacts"];
  std::vector<double>& at_walls = to.reals["wall_springs"];
  walls.clear(), at_walls.clear();
  for (const WallRecord& w : from.walls) {
    walls.insert(walls.end(), {w.grain, grains + w.side});
    at_walls.insert(at_walls.end(), {w.since, w.impact_speed, w.spring.x, w.spring.y, w.spring.z});
  }
}

}  // namespace

void store_contacts(const Snapshot& from, Checkpoint& to) {
  std::vector<std::size_t> order(from.contacts.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, [&](std::size_t k) { return std::pair{from.contacts[k].i, from.contacts[k].j}; });
  std::vector<std::int64_t>& pairs = to.integers["contact_pairs"];
  std::vector<double>& touches = to.reals["contact_touches"];
  pairs.clear();
  touches.clear();
  for (const std::size_t k : order) {
    const OpenContact& c = from.contacts[k];
    pairs.insert(pairs.end(), {c.i, c.j, c.alone});
    touches.insert(touches.end(), {c.since, c.impact_speed});
  }
  if (!from.rough) return;
  std::vector<double>& springs = to.reals["surface_springs"];
  springs.clear();
  for (const std::size_t k : order) {
    const Vec3 s = from.rough->springs[k];
    springs.insert(springs.end(), {s.x, s.y, s.z});
  }
  store_walls(*from.rough, to);
}

void store(const Snapshot& snapshot, Checkpoint& checkpoint) {
  store_grains(snapshot, checkpoint);
  store_contacts(snapshot, checkpoint);
  if (snapshot.rough) store_rotation(*snapshot.rough, checkpoint);
  const Counters& count = snapshot.count;
  if (snapshot.exchanges) {
    std::vector<std::int64_t>& transfers = checkpoint.integers["effects.charge_exchange.counters"];
    transfers.at(1) = count.transfers, transfers.at(2) = count.refused;
  }
  if (snapshot.sums) checkpoint.integers["effects.coulomb.counters"].at(0) = count.evaluations;
  checkpoint.reals["time"] = {snapshot.time};
  checkpoint.integers["counters"] = {count.steps, count.contact_steps, count.collisions};
  std::vector<double>& budget = checkpoint.reals["book"];
  budget.at(0) = snapshot.dissipated, budget.at(1) = snapshot.exchanged, budget.at(2) = snapshot.driven;
  budget.at(4) = snapshot.overlap;
  checkpoint.reals["restitution_check"] = snapshot.restitution;
  if (snapshot.dipoles) snapshot.dipoles(checkpoint);
}

}  // namespace lichtenberg::granular::device
