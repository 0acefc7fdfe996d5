#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "solvers/neighbours/cell_order.hpp"
#include "src/granular/pair_state.hpp"
#include "src/granular/pair_table.hpp"

namespace lichtenberg::granular {

/// What grains may do until pairs are looked for anew.
struct Bounds {
  double fastest = 0;       ///< without contacts; no collision makes one faster than twice that
  double jolt = 0;          ///< by which all but contacts may change a velocity at once, together
  double pull = 0;          ///< by which all but contacts accelerate a grain
  double acceleration = 0;  ///< of two towards each other by contacts
  double excess = 0;        ///< by how much more than that two may come closer in a step whose middle does not show it

  double speed() const { return 2 * fastest; }
  /// How much closer two come within t than in straight flight, at most, by contacts.
  double bend(double t) const { return std::min(0.5 * acceleration * t * t, 3 * speed() * t); }
  /// The same by all that acts on them.
  double closed_by(double t) const { return 2 * jolt * t + bend(t) + pull * t * t; }
  /// How much closer than they are two may come within t.
  double approach(double t) const { return std::min(2 * speed() * t, 2 * fastest * t + bend(t)) + excess; }
};

inline constexpr double rounding = 1e-9;  ///< of lengths: more than that of places, less than what matters

/// For how long pairs stay apart, at least. In straight flight the distance of two is a convex function of time: they
/// come closer never faster than at first, c, and where that is negative they part at least so fast from then on. Jolts
/// make c larger, all else but contacts brings them 2 pull t^2 / 2 closer, and contacts a t^2 / 2 or 3 speeds t: their
/// gap lasts longer than either way has it closed.
template <int d>
Several apart_for(const PairState<d, Several>& pairs, const Several& reach, const Bounds& bounds) {
  const Several distance = sqrt(norm2(pairs.apart));
  const Several gap = not_below<Several>(distance - ((1 + rounding) * reach + bounds.excess), 0);
  // The root of speed t + acceleration t^2 / 2 = gap, without a difference of like numbers.
  const auto closed_after = [&](const Several& speed, double acceleration) {
    const Several root = sqrt(speed * speed + 2 * acceleration * gap);
    const auto parting = speed < 0;
    return chosen<Several>(parting, root - speed, 2.0 * gap) / chosen<Several>(parting, acceleration, speed + root);
  };
  const Several closing = 2 * bounds.jolt - dot(pairs.apart, pairs.velocity) / distance;
  const Several bent = closed_after(closing, bounds.acceleration + 2 * bounds.pull);
  const Several time = not_below<Several>(bent, closed_after(closing + 3 * bounds.speed(), 2 * bounds.pull));
  return chosen<Several>(gap > 0, time, 0);
}

/// Pairs that are apart, each with the time before which it cannot touch, from one search for pairs to the next.
/// Which are waited for, and since when, decides what is looked at and changes no result.
template <int d>
class Encounters {
 public:
  static constexpr double longer = 1.25;

  /// Velocities have been changed at once by so much, and not by contacts.
  void jolt(double most) { jolts_ += most; }
  /// All but contacts accelerate no grain by more than that, until somebody says so again.
  void pull(double acceleration) { pull_ = acceleration; }
  /// Contacts, or all there is, accelerate a grain by so much in the middle of a step. False if they may push harder in
  /// it than was thought, and pairs have to be searched for at its beginning.
  bool bear(double acceleration) {
    constexpr double margin = 1.2;  // by which pushes may grow from there to the end
    hardest_push_ = std::max(hardest_push_, acceleration);
    return 2 * margin * hardest_push_ <= bounds_.acceleration;
  }
  double hardest_push() const { return hardest_push_; }  ///< since the search
  /// Whether all pairs that may touch within a step of `time` from now are waited for; `fastest`: what is the largest
  /// speed now. What a step's middle does not show grows with the step, which may be `longer` than the search's.
  bool cover(double time, double fastest) const {
    return now_ + time <= horizon_ && time <= longer * bucket_ && fastest <= bounds_.speed() &&
           jolts_ <= bounds_.jolt && pull_ <= bounds_.pull;
  }
  /// Looks for all pairs that may touch within `horizon`, without those that are open, for steps of length `step`.
  template <class IsOpen>
  void search(const Bodies& bodies, const Bounds& bounds, double horizon, double step, const IsOpen& is_open,
              parallel::Team& team);
  /// This pair cannot touch before t from now.
  void wait(Pair pair, double t);
  /// Moves the pairs to `due` that may touch before dt from now.
  void take(double dt, std::vector<Pair>& due);
  /// Time goes by.
  void pass(double dt) { now_ += dt; }
  const Bounds& bounds() const { return bounds_; }

 private:
  static constexpr int pairs_a_task = 4096;  ///< a multiple of any width
  static constexpr int spots_a_task = 4096;
  static constexpr double slack = 1e-6;  ///< of a bucket's time: more than sums of steps are rounded by
  static constexpr int ahead = 16;
  struct alignas(64) Spot {
    std::array<double, d> place, velocity;
    double radius = 0;
  };

  void copy_spots(const Bodies& bodies, parallel::Team& team);
  void estimate(const std::vector<Pair>& pairs, parallel::Team& team);

  Bounds bounds_;
  double now_ = 0, horizon_ = -1, bucket_ = 1;  ///< times since the search
  double jolts_ = 0, pull_ = 0, hardest_push_ = 0;
  std::size_t next_ = 0;                    ///< the first bucket that is not taken
  std::vector<std::vector<Pair>> waiting_;  ///< by the bucket of time in which they may touch
  std::vector<Pair> soon_;                  ///< in a bucket that is taken already
  CellOrder<d> cells_;
  NearestImage<d> nearest_{Box<d>{}};
  std::vector<Spot> spots_;  ///< by slot
  std::vector<double> apart_for_;
};

template <int d>
void Encounters<d>::copy_spots(const Bodies& bodies, parallel::Team& team) {
  const int n = bodies.size();
  spots_.resize(n);
  const auto copy = [&](int s) {
    const int i = cells_.particles()[s], later = cells_.particles()[std::min(s + ahead, n - 1)];
    __builtin_prefetch(&bodies.position[later * d]);
    __builtin_prefetch(&bodies.momentum[later * d]);
    Spot& spot = spots_[s];
    const double per_mass = 1 / bodies.mass[i];
    for (int k = 0; k < d; ++k) {
      spot.place[k] = bodies.position[i * d + k];
      spot.velocity[k] = per_mass * bodies.momentum[i * d + k];
    }
    spot.radius = bodies.radius[i];
    Vec<d> velocity;
    for (int k = 0; k < d; ++k) velocity[k] = spot.velocity[k];
    cells_.set_velocity(s, velocity);
  };
  team.for_each((n + spots_a_task - 1) / spots_a_task, [&](int task) {
    for (int s = task * spots_a_task; s < std::min(n, (task + 1) * spots_a_task); ++s) copy(s);
  });
}

/// Of pairs of slots.
template <int d>
void Encounters<d>::estimate(const std::vector<Pair>& pairs, parallel::Team& team) {
  const int count = static_cast<int>(pairs.size());
  apart_for_.resize(count + width);
  team.for_each((count + pairs_a_task - 1) / pairs_a_task, [&](int task) {
    const int end = std::min(count, (task + 1) * pairs_a_task);
    for (int first = task * pairs_a_task; first < end; first += width) {
      const auto of = [&](const auto& value) {
        return Several([&](int lane) {
          const Pair pair = pairs[std::min(first + lane, count - 1)];
          return value(spots_[pair.i], spots_[pair.j]);
        });
      };
      PairState<d, Several> state;
      for (int k = 0; k < d; ++k) {
        const Several x = of([k](const Spot& i, const Spot& j) { return j.place[k] - i.place[k]; });
        state.apart[k] = x - nearest_.length[k] * nearbyint(x * nearest_.turns_a_metre[k]);
        state.velocity[k] = of([k](const Spot& i, const Spot& j) { return j.velocity[k] - i.velocity[k]; });
      }
      const Several reach = of([](const Spot& i, const Spot& j) { return i.radius + j.radius; });
      apart_for<d>(state, reach, bounds_).copy_to(&apart_for_[first], anywhere);
    }
  });
}

template <int d>
template <class IsOpen>
void Encounters<d>::search(const Bodies& bodies, const Bounds& bounds, double horizon, double step,
                           const IsOpen& is_open, parallel::Team& team) {
  bounds_ = bounds;
  now_ = jolts_ = hardest_push_ = 0;
  next_ = 0;
  horizon_ = horizon;
  bucket_ = step;
  soon_.clear();
  waiting_.resize(static_cast<std::size_t>(std::ceil(horizon / step)) + 1);
  for (auto& bucket : waiting_) bucket.clear();

  const Spheres<d> grains = spheres<d>(bodies);
  nearest_ = NearestImage<d>(grains.box);
  const double widest = *std::ranges::max_element(bodies.radius);
  cells_.sort(grains, (2 + rounding) * widest + bounds.approach(horizon));
  copy_spots(bodies, team);
  // All with a smaller apart_for() than the horizon, as if all were as wide as the widest.
  const double reach = (1 + rounding) * 2 * widest + bounds.excess;
  const std::vector<Pair>& pairs =
      cells_.pairs_that_meet({.time = horizon, .within = reach + bounds.closed_by(horizon), .near = reach}, team);
  estimate(pairs, team);
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    if (!(apart_for_[p] < horizon)) continue;
    const int i = cells_.particles()[pairs[p].i], j = cells_.particles()[pairs[p].j];
    const Pair pair{std::min(i, j), std::max(i, j)};
    if (!is_open(pair)) wait(pair, apart_for_[p]);
  }
}

template <int d>
void Encounters<d>::wait(Pair pair, double t) {
  const double bucket = std::floor((now_ + t) / bucket_ - slack);
  if (bucket < static_cast<double>(next_))
    soon_.push_back(pair);
  else if (bucket < static_cast<double>(waiting_.size()))
    waiting_[static_cast<std::size_t>(bucket)].push_back(pair);
}

template <int d>
void Encounters<d>::take(double dt, std::vector<Pair>& due) {
  due.swap(soon_);
  soon_.clear();
  for (; next_ < waiting_.size() && static_cast<double>(next_) * bucket_ < now_ + dt - slack * bucket_; ++next_)
    due.insert(due.end(), waiting_[next_].begin(), waiting_[next_].end());
}

}  // namespace lichtenberg::granular
