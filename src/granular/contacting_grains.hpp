#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "solvers/geometry/vec.hpp"
#include "solvers/neighbours/pairs.hpp"
#include "solvers/parallel/team.hpp"
#include "src/granular/pair_state.hpp"
#include "src/granular/pair_table.hpp"
#include "src/model/bodies.hpp"

namespace lichtenberg::granular {

/// State of one grain of each pair in a SIMD vector of pairs.
template <int d>
struct GrainPack {
  Vectors<d> position, velocity;
  SimdPack per_mass, radius;
};

/// Returns the states of pairs of grains, of the higher with respect to the nearest image of the lower one.
template <int d>
PairState<d, SimdPack> relative_state(const GrainPack<d>& lower, const GrainPack<d>& higher,
                                      const NearestImage<d>& nearest) {
  PairState<d, SimdPack> state;
  for (int k = 0; k < d; ++k) {
    const SimdPack x = higher.position[k] - lower.position[k];
    state.separation[k] = x - nearest.length[k] * nearbyint(x * nearest.inverse_length[k]);
    state.velocity[k] = higher.velocity[k] - lower.velocity[k];
  }
  return state;
}

/// Positions and momenta of the grains of a gas during contact substeps of equal length. Grains that are or may come in
/// contact have copies in contiguous arrays (slots). The others remain in the bodies and move from the start to the end
/// in a single step. Slow forces (all forces except contacts) are constant and act on all grains. Reduced units.
template <int d>
class ContactingGrains {
 public:
  /// State of a grain after the last step with a contact, or at the start of the substeps; it fills one cache line.
  struct alignas(64) Grain {
    std::array<double, d> position, momentum;
    double per_mass = 0;           ///< 1 / mass
    std::int32_t followed_to = 0;  ///< index of the step at whose start the grain has this state
    std::int32_t particle = 0;     ///< index of the grain in the bodies
  };
  /// Total forces on a grain at the start and in the middle of a step, in one cache line.
  struct alignas(64) GrainForces {
    std::array<double, d> start, halfway;
    double radius = 0;
    std::int32_t touches = 0;  ///< number of contacts of the grain
  };

  /// Starts substeps of length dt (t0) from the bodies, which must not change before fly(). `slow_force`: constant
  /// forces ([N * d]; empty: none). The grains of the pairs pair_of(p), p < contacts, get the first slots. Masses and
  /// radii are those of the first call.
  template <class PairOf>
  void begin(const Bodies& bodies, std::span<const double> slow_force, double dt, int contacts, const PairOf& pair_of,
             parallel::Team& team);
  /// Returns the slot (index of the copy) of a grain, and makes a copy if it has none. `particle`: index in the bodies.
  int slot_of(int particle);
  double widest() const { return widest_; }      ///< largest radius (d0)
  double lightest() const { return lightest_; }  ///< smallest mass (m0)

  int slots() const { return static_cast<int>(grains_.size()); }
  const Grain& grain(int slot) const { return grains_[slot]; }
  const GrainForces& forces(int slot) const { return forces_[slot]; }
  GrainForces& forces(int slot) { return forces_[slot]; }
  bool has_slow_forces() const { return !slot_slow_forces_.empty(); }
  const std::array<double, d>& slow_force(int slot) const { return slot_slow_forces_[slot]; }

  /// Returns the state at the start of step n of the grain in a slot, if no contact acts on it until then.
  Grain flown(int slot, int n) const;
  /// Returns the states of a SIMD vector of grains at the start of step n, if no contact acts on them until then. The
  /// grains need no slots and get none. particle(lane): index in the bodies.
  template <class Particle>
  GrainPack<d> at(const Particle& particle, int n) const;
  /// Moves the grain in a slot to the start of step n, if needed, and adds the effect of a contact in the step before.
  /// It adds by * shift to the position and sign * impulse to the momentum.
  void apply_contact(int slot, int n, double by, const Vec<d>& shift, double sign, const Vec<d>& impulse);
  /// Moves all grains in `bodies` (those of begin() or a copy) to the start of step n, including the effects of
  /// contacts from apply_contact(). Returns the work of the slow forces.
  double fly(Bodies& bodies, int n, parallel::Team& team) const;
  /// Prefetches the memory of the two grains of a pair.
  void prefetch(Pair pair) const;
  void prefetch(int slot) const { __builtin_prefetch(&grains_[slot], 1); }

  static constexpr int ahead = 16;  ///< prefetch distance, in pairs or grains

 private:
  static constexpr int grains_a_task = 4096;
  struct Properties {
    double per_mass = 0, radius = 0;
  };

  void make(const Bodies& bodies);
  void prefetch_particle(int particle) const;
  bool has_slot(int particle) const { return slot_[particle] >= 0; }
  int new_slot(int particle);
  void fill(int slot);
  double fly_all(Bodies& bodies, double t, int first, int last) const;
  double write_back(Bodies& bodies, int n, int first, int last) const;
  /// Returns the sum of visit(first, last) over ranges of the indices 0 ... count - 1, first <= i < last. The ranges
  /// are computed in parallel and added in ascending order.
  template <class Visit>
  static double sum_over_ranges(int count, parallel::Team& team, const Visit& visit);

  const Bodies* bodies_ = nullptr;       ///< at the start
  std::span<const double> slow_forces_;  ///< [N * d]; empty: none
  double dt_ = 0, widest_ = 0, lightest_ = INFINITY;
  std::vector<Properties> properties_;  ///< by particle
  std::vector<std::int32_t> slot_;      ///< by particle; -1: none
  // By slot.
  std::vector<Grain> grains_;
  std::vector<GrainForces> forces_;
  std::vector<std::array<double, d>> slot_slow_forces_;  ///< empty: none
};

template <int d>
void ContactingGrains<d>::make(const Bodies& bodies) {
  for (int i = 0; i < bodies.size(); ++i) properties_.push_back({1 / bodies.mass[i], bodies.radius[i]});
  slot_.assign(bodies.size(), -1);
  widest_ = *std::ranges::max_element(bodies.radius);
  lightest_ = *std::ranges::min_element(bodies.mass);
}

template <int d>
template <class PairOf>
void ContactingGrains<d>::begin(const Bodies& bodies, std::span<const double> slow_force, double dt, int contacts,
                                const PairOf& pair_of, parallel::Team& team) {
  bodies_ = &bodies;
  slow_forces_ = slow_force;
  dt_ = dt;
  if (properties_.empty()) make(bodies);
  for (const Grain& grain : grains_) slot_[grain.particle] = -1;
  grains_.clear();
  forces_.clear();
  slot_slow_forces_.clear();
  for (int p = 0; p < contacts; ++p) {
    const Pair pair = pair_of(p);
    for (const int i : {pair.i, pair.j}) {
      if (!has_slot(i)) new_slot(i);
      ++forces_[slot_[i]].touches;
    }
  }
  const int count = slots();
  sum_over_ranges(count, team, [&](int first, int last) {
    for (int s = first; s < last; ++s) {
      prefetch_particle(grains_[std::min(s + ahead, count - 1)].particle);
      fill(s);
    }
    return 0.0;
  });
}

template <int d>
int ContactingGrains<d>::new_slot(int particle) {
  const int slot = slot_[particle] = slots();
  grains_.emplace_back().particle = particle;
  forces_.emplace_back();
  if (!slow_forces_.empty()) slot_slow_forces_.emplace_back();
  return slot;
}

template <int d>
[[gnu::always_inline]] inline void ContactingGrains<d>::fill(int slot) {
  Grain& grain = grains_[slot];
  const int particle = grain.particle;
  for (int k = 0; k < d; ++k) {
    grain.position[k] = bodies_->position[particle * d + k];
    grain.momentum[k] = bodies_->momentum[particle * d + k];
    if (has_slow_forces()) slot_slow_forces_[slot][k] = slow_forces_[particle * d + k];
  }
  grain.per_mass = properties_[particle].per_mass;
  forces_[slot].radius = properties_[particle].radius;
}

template <int d>
int ContactingGrains<d>::slot_of(int particle) {
  if (has_slot(particle)) return slot_[particle];
  const int slot = new_slot(particle);
  fill(slot);
  return slot;
}

template <int d>
void ContactingGrains<d>::prefetch(Pair pair) const {
  for (const int i : {pair.i, pair.j}) {
    __builtin_prefetch(&slot_[i]);
    prefetch_particle(i);
  }
}

template <int d>
void ContactingGrains<d>::prefetch_particle(int particle) const {
  __builtin_prefetch(&properties_[particle]);
  __builtin_prefetch(&bodies_->position[particle * d]);
  __builtin_prefetch(&bodies_->momentum[particle * d]);
  if (!slow_forces_.empty()) __builtin_prefetch(&slow_forces_[particle * d]);
}

template <int d>
[[gnu::always_inline]] inline auto ContactingGrains<d>::flown(int slot, int n) const -> Grain {
  Grain grain = grains_[slot];
  const double t = (n - grain.followed_to) * dt_, path = t * grain.per_mass;
  grain.followed_to = n;
  for (int k = 0; k < d; ++k)
    if (slot_slow_forces_.empty())
      grain.position[k] += path * grain.momentum[k];
    else
      granular::fly(grain.position[k], grain.momentum[k], slot_slow_forces_[slot][k], grain.per_mass, t);
  return grain;
}

template <int d>
template <class Particle>
[[gnu::always_inline]] inline GrainPack<d> ContactingGrains<d>::at(const Particle& particle, int n) const {
  std::array<const double*, width> position, momentum;
  std::array<double, width> flight;
  for (int lane = 0; lane < width; ++lane) {
    const int i = particle(lane), slot = slot_[i];
    position[lane] = slot >= 0 ? grains_[slot].position.data() : &bodies_->position[i * d];
    momentum[lane] = slot >= 0 ? grains_[slot].momentum.data() : &bodies_->momentum[i * d];
    flight[lane] = dt_ * (slot >= 0 ? n - grains_[slot].followed_to : n);
  }
  GrainPack<d> s;
  s.per_mass = SimdPack([&](int lane) { return properties_[particle(lane)].per_mass; });
  s.radius = SimdPack([&](int lane) { return properties_[particle(lane)].radius; });
  const SimdPack t(flight.data(), anywhere);
  for (int k = 0; k < d; ++k) {
    s.position[k] = SimdPack([&](int lane) { return position[lane][k]; });
    SimdPack p([&](int lane) { return momentum[lane][k]; }), force = 0;
    if (!slow_forces_.empty()) force = SimdPack([&](int lane) { return slow_forces_[particle(lane) * d + k]; });
    granular::fly(s.position[k], p, force, s.per_mass, t);
    s.velocity[k] = p * s.per_mass;
  }
  return s;
}

template <int d>
[[gnu::always_inline]] inline void ContactingGrains<d>::apply_contact(int slot, int n, double by, const Vec<d>& shift,
                                                                      double sign, const Vec<d>& impulse) {
  Grain& grain = grains_[slot];
  if (grain.followed_to != n) grain = flown(slot, n);
  for (int k = 0; k < d; ++k) {
    grain.position[k] += by * shift[k];
    grain.momentum[k] += sign * impulse[k];
  }
}

template <int d>
template <class Visit>
double ContactingGrains<d>::sum_over_ranges(int count, parallel::Team& team, const Visit& visit) {
  std::vector<double> sums((count + grains_a_task - 1) / grains_a_task);
  team.for_each(static_cast<int>(sums.size()), [&](int task) {
    sums[task] = visit(task * grains_a_task, std::min(count, (task + 1) * grains_a_task));
  });
  double sum = 0;
  for (const double part : sums) sum += part;
  return sum;
}

/// Moves the bodies first <= i < last through a time t (t0) without contacts. Returns the work of the slow forces.
template <int d>
double ContactingGrains<d>::fly_all(Bodies& bodies, double t, int first, int last) const {
  std::array<double, d> work{};
  for (int i = first; i < last; ++i) {
    const double path = t * properties_[i].per_mass;
    for (int k = 0; k < d; ++k) {
      double& momentum = bodies.momentum[i * d + k];
      if (slow_forces_.empty()) {
        bodies.position[i * d + k] += path * momentum;
      } else {
        const double slow_force = slow_forces_[i * d + k], displacement = path * (momentum + 0.5 * t * slow_force);
        work[k] += slow_force * displacement;
        bodies.position[i * d + k] += displacement;
        momentum += t * slow_force;
      }
    }
  }
  double sum = 0;
  for (const double part : work) sum += part;
  return sum;
}

/// Overwrites the bodies of the slots first <= s < last, which fly_all() has moved without contacts, with their states
/// at the start of step n. Returns the resulting change of the work of the slow forces.
template <int d>
double ContactingGrains<d>::write_back(Bodies& bodies, int n, int first, int last) const {
  double work = 0;
  for (int s = first; s < last; ++s) {
    const int later = grains_[std::min(s + ahead, last - 1)].particle;
    __builtin_prefetch(&bodies.position[later * d], 1);
    __builtin_prefetch(&bodies.momentum[later * d], 1);
    const Grain grain = flown(s, n);
    for (int k = 0; k < d; ++k) {
      double& position = bodies.position[grain.particle * d + k];
      if (has_slow_forces()) work += slot_slow_forces_[s][k] * (grain.position[k] - position);
      position = grain.position[k];
      bodies.momentum[grain.particle * d + k] = grain.momentum[k];
    }
  }
  return work;
}

template <int d>
double ContactingGrains<d>::fly(Bodies& bodies, int n, parallel::Team& team) const {
  const double free =
      sum_over_ranges(bodies.size(), team, [&](int first, int last) { return fly_all(bodies, n * dt_, first, last); });
  return free + sum_over_ranges(slots(), team, [&](int first, int last) { return write_back(bodies, n, first, last); });
}

}  // namespace lichtenberg::granular
