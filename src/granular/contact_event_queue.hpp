#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "solvers/neighbours/cell_order.hpp"
#include "src/granular/pair_state.hpp"
#include "src/granular/pair_table.hpp"

namespace lichtenberg::granular {

/// Upper bounds on speeds and accelerations of grains until the next search for candidate pairs (pairs that may touch),
/// in reduced units.
struct Bounds {
  double fastest = 0;                ///< largest speed without contacts (v0); collisions at most double it
  double velocity_kick = 0;          ///< sum of velocity changes by all forces except contacts (v0)
  double external_acceleration = 0;  ///< acceleration of a grain by slow forces (all forces except contacts)
  double contact_acceleration = 0;   ///< relative acceleration of two grains by contacts
  double excess = 0;                 ///< margin for contacts that begin in the second half of a step (d0)

  double speed() const { return 2 * fastest; }  ///< largest speed with collisions (v0)
  /// Returns an upper bound on the approach of two grains (d0) within a time t due to contacts, in addition to straight
  /// flight.
  double contact_deviation(double t) const { return std::min(0.5 * contact_acceleration * t * t, 3 * speed() * t); }
  /// Returns an upper bound on the approach of two grains (d0) within a time t, in addition to straight flight. It
  /// includes contacts, slow forces and velocity kicks.
  double closed_by(double t) const {
    return 2 * velocity_kick * t + contact_deviation(t) + external_acceleration * t * t;
  }
  /// Returns an upper bound on the total approach of two grains (d0) within a time t, plus `excess`.
  double approach(double t) const { return std::min(2 * speed() * t, 2 * fastest * t + contact_deviation(t)) + excess; }
};

/// Relative margin of lengths: above the rounding of positions, below relevant gaps.
inline constexpr double rounding = 1e-9;

/// Returns lower bounds on the times (t0) until contact for a SIMD vector of separate pairs. `reach`: sums of the radii
/// (d0).
///
/// In straight flight the distance is a convex function of time, so the approach speed c is largest at first. Kicks
/// increase c. Slow forces with the largest acceleration e add an approach of at most e t^2. Contacts add at most a t^2
/// / 2 (a: contact acceleration) and at most 3 u t (u: Bounds::speed()). Each of these two estimates gives a time at
/// which the gap is closed; the result is the later one.
template <int d>
SimdPack min_time_to_contact(const PairState<d, SimdPack>& pairs, const SimdPack& reach, const Bounds& bounds) {
  const SimdPack distance = sqrt(norm2(pairs.separation));
  const SimdPack gap = not_below<SimdPack>(distance - ((1 + rounding) * reach + bounds.excess), 0);
  // The root of speed t + acceleration t^2 / 2 = gap, without cancellation.
  const auto closed_after = [&](const SimdPack& speed, double acceleration) {
    const SimdPack root = sqrt(speed * speed + 2 * acceleration * gap);
    const auto parting = speed < 0;
    return chosen<SimdPack>(parting, root - speed, 2.0 * gap) / chosen<SimdPack>(parting, acceleration, speed + root);
  };
  const SimdPack closing = 2 * bounds.velocity_kick - dot(pairs.separation, pairs.velocity) / distance;
  const SimdPack with_contact = closed_after(closing, bounds.contact_acceleration + 2 * bounds.external_acceleration);
  const SimdPack time =
      not_below<SimdPack>(with_contact, closed_after(closing + 3 * bounds.speed(), 2 * bounds.external_acceleration));
  return chosen<SimdPack>(gap > 0, time, 0);
}

/// Queue of candidate pairs (separate pairs that may touch), sorted by the earliest possible time of contact (event
/// detection). A search fills it for a time, the horizon. Its contents affect the cost but no result.
template <int d>
class ContactEventQueue {
 public:
  static constexpr double longer = 1.25;  ///< largest ratio of a later step to the step of the search

  /// Adds an upper bound on a change of velocities (v0) by forces other than contacts.
  void add_velocity_kick(double most) { velocity_kicks_ += most; }
  /// Sets an upper bound on the acceleration of a grain by slow forces (reduced units).
  void set_external_acceleration(double acceleration) { external_acceleration_ = acceleration; }
  /// Records the largest acceleration of a grain in the middle of a step. Returns false if accelerations in this step
  /// may exceed the bound that the search assumed. The caller must then repeat the search at the start of the step.
  bool update_contact_acceleration(double acceleration) {
    constexpr double margin = 1.2;  // bound on the growth of accelerations from the middle to the end
    max_contact_acceleration_ = std::max(max_contact_acceleration_, acceleration);
    return 2 * margin * max_contact_acceleration_ <= bounds_.contact_acceleration;
  }
  /// Returns the largest recorded acceleration of a grain since the search (reduced units).
  double max_contact_acceleration() const { return max_contact_acceleration_; }
  /// Returns true if the queue has all separate pairs that may touch within a step of length `time` (t0). `fastest`:
  /// largest speed of a grain (v0). The step may be at most `longer` times as long as the step of the search.
  bool is_valid_for(double time, double fastest) const {
    return now_ + time <= horizon_ && time <= longer * bucket_ && fastest <= bounds_.speed() &&
           velocity_kicks_ <= bounds_.velocity_kick && external_acceleration_ <= bounds_.external_acceleration;
  }
  /// Fills the queue with all pairs that may touch within a time `horizon` (t0) from now, except pairs in contact. The
  /// next take() returns all of them; wait() then sorts those that may touch later by time.
  /// `step`: expected length of steps (t0); is_open(pair): true for a pair in contact.
  template <class IsOpen>
  void search(const Bodies& bodies, const Bounds& bounds, double horizon, double step, const IsOpen& is_open,
              parallel::Team& team);
  /// Adds a pair that cannot touch within a time t (t0) from now. Pairs beyond the time for which the queue is filled
  /// (`horizon` of the search) are left out.
  void wait(Pair pair, double t);
  /// Removes the pairs that may touch within a time dt (t0) from now, and stores them in `due`. It may also take pairs
  /// that touch somewhat later.
  void take(double dt, std::vector<Pair>& due);
  /// Advances the time of the queue by dt (t0).
  void pass(double dt) { now_ += dt; }
  const Bounds& bounds() const { return bounds_; }

 private:
  static constexpr double slack = 1e-6;  ///< relative to a bucket's duration: above the rounding of sums of steps

  Bounds bounds_;
  double now_ = 0, horizon_ = -1, bucket_ = 1;  ///< t0; now and horizon: since the search
  double velocity_kicks_ = 0, external_acceleration_ = 0, max_contact_acceleration_ = 0;
  std::size_t next_ = 0;                    ///< first bucket that has not been taken
  std::vector<std::vector<Pair>> waiting_;  ///< [buckets of time]
  std::vector<Pair> soon_;                  ///< pairs of buckets that have been taken
  CellOrder<d> cells_;
};

template <int d>
template <class IsOpen>
void ContactEventQueue<d>::search(const Bodies& bodies, const Bounds& bounds, double horizon, double step,
                                  const IsOpen& is_open, parallel::Team& team) {
  bounds_ = bounds;
  now_ = velocity_kicks_ = max_contact_acceleration_ = 0;
  next_ = 0;
  horizon_ = horizon;
  bucket_ = step;
  soon_.clear();
  waiting_.resize(static_cast<std::size_t>(std::ceil(horizon / step)) + 1);
  for (auto& bucket : waiting_) bucket.clear();

  const Spheres<d> grains = spheres<d>(bodies);
  const double widest = *std::ranges::max_element(bodies.radius);
  cells_.sort(grains, (2 + rounding) * widest + bounds.approach(horizon));
  for (int i = 0; i < bodies.size(); ++i) {
    const double per_mass = 1 / bodies.mass[i];
    Vec<d> velocity;
    for (int k = 0; k < d; ++k) velocity[k] = per_mass * bodies.momentum[i * d + k];
    cells_.set_velocity(cells_.slots()[i], velocity);
  }
  // These pairs include all with min_time_to_contact() below the horizon, also if all grains had the largest radius.
  const double reach = (1 + rounding) * 2 * widest + bounds.excess;
  for (const auto& [a, b] :
       cells_.pairs_that_meet({.time = horizon, .within = reach + bounds.closed_by(horizon), .near = reach}, team)) {
    const int i = cells_.particles()[a], j = cells_.particles()[b];
    const Pair pair{std::min(i, j), std::max(i, j)};
    if (!is_open(pair)) soon_.push_back(pair);
  }
}

template <int d>
void ContactEventQueue<d>::wait(Pair pair, double t) {
  const double bucket = std::floor((now_ + t) / bucket_ - slack);
  if (bucket < static_cast<double>(next_))
    soon_.push_back(pair);
  else if (bucket < static_cast<double>(waiting_.size()))
    waiting_[static_cast<std::size_t>(bucket)].push_back(pair);
}

template <int d>
void ContactEventQueue<d>::take(double dt, std::vector<Pair>& due) {
  due.swap(soon_);
  soon_.clear();
  for (; next_ < waiting_.size() && static_cast<double>(next_) * bucket_ < now_ + dt - slack * bucket_; ++next_)
    due.insert(due.end(), waiting_[next_].begin(), waiting_[next_].end());
}

}  // namespace lichtenberg::granular
