#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "src/granular/contact_event_queue.hpp"
#include "src/granular/contacting_grains.hpp"
#include "src/granular/pair_motion.hpp"
#include "src/granular/pair_table.hpp"

namespace lichtenberg::granular {

/// Values of the pairs that are computed in a step, one column per quantity (reduced units).
template <int d>
struct PairColumns {
  Table table;
  Column reach{table}, mass{table}, scale{table};    ///< sum of radii, reduced mass, the law's factor
  Column lower{table}, higher{table};                ///< 1 / mass of the lower and the higher grain
  Column age{table}, overlap{table}, stored{table};  ///< age < 0: no contact
  VectorColumn<d> apart{table}, velocity{table};
  VectorColumn<d> force{table};    ///< on the higher grain, at the start of the step
  VectorColumn<d> outside{table};  ///< relative acceleration by all other forces, at the start
  VectorColumn<d> halfway_force{table};
  Column felt{table};                            ///< square of the larger acceleration of the two in mid-step
  VectorColumn<d> impulse{table}, shift{table};  ///< on the higher grain; shift: displacement times mass
  Column dissipated{table}, touched{table}, impact_speed{table};

  PairState<d> state(int pair) const { return {apart[pair], velocity[pair]}; }
};

/// Motion of pairs over one step: first the pairs in contact, then the candidate pairs. A vector register holds several
/// pairs. Devices run the formulas of pair_motion.hpp in a sweep of their own (device/contact_steps.hpp). Their threads
/// take one pair each and add to sums atomically, while the CPU reads columns of pairs row by row.
template <int d, class Law>
class ContactRows {
 public:
  ContactRows(const Law& law, ContactingGrains<d>& grains) : law_(law), grains_(grains) {}

  void begin(const Box<d>& box, double dt) {
    nearest_ = NearestImage<d>(box);
    dt_ = dt;
  }
  /// Computes states and forces of the `touching` pairs in contact; the force of an ended contact is zero.
  /// `slots_of(p)` and `since_of(p)` give the grains of a pair and the time of its onset.
  template <class SlotsOf, class SinceOf>
  void look(int touching, const SlotsOf& slots_of, const SinceOf& since_of, double time, bool all_touch,
            parallel::Team& team);
  /// Adds candidate pairs that are apart at the start of step n.
  template <class SlotsOf>
  void add(int candidates, const SlotsOf& slots_of, int n, parallel::Team& team);
  /// Computes the motion of all pairs to the end of the step. `move` transfers it to the grains.
  void follow(parallel::Team& team);
  void move(int n);
  /// Returns the largest acceleration of a grain in the middle of the computed step.
  double max_contact_acceleration() const;

  int touching() const { return touching_; }
  int count() const { return count_; }
  Pair slots(int pair) const { return pair_[pair]; }
  const PairColumns<d>& of() const { return of_; }

 private:
  static constexpr int pairs_a_task = 512;  ///< a multiple of any vector width
  static constexpr int ahead = ContactingGrains<d>::ahead;
  using Felt = typename ContactingGrains<d>::Felt;
  using Forces = std::array<double, d> Felt::*;
  /// The law with the factor of each pair.
  struct OfPairs {
    const Law& law;
    Several scale;

    ContactPush<Several> operator()(const Several& overlap) const { return law.push(overlap, scale); }
  };
  using Pairs = PairMotion<d, OfPairs, Several>;
  /// One grain of each pair in a vector.
  struct Seen {
    Vectors<d> place, velocity;
    Several per_mass;
  };

  void resize(int pairs);
  /// Calls visit(row) for the rows from `first`, a multiple of the width, to `last`.
  template <class Visit>
  void for_each_row(int first, int last, parallel::Team& team, const Visit& visit) {
    team.for_each((last - first + pairs_a_task - 1) / pairs_a_task, [&](int task) {
      const int begin = first + task * pairs_a_task;
      for (int p = begin; p < std::min(last, begin + pairs_a_task); p += width) visit(Row{p});
    });
  }
  template <bool flies, class Slot>
  Seen seen(const Slot& slot, int n) const;
  PairState<d, Several> between(const Seen& lower, const Seen& higher) const;
  template <bool flies>
  void see(Row row, int n);
  void push(Row row);
  void feel_each_other(parallel::Team& team);
  void add(Forces when, Pair pair, const Vec<d>& push);
  template <class Those>
  std::array<Vectors<d>, 2> felt(Forces when, const Those& of) const;
  template <class Those>
  Vectors<d> relative(const std::array<Vectors<d>, 2>& forces, const Those& of) const;
  template <class Those, class Go>
  auto follow_those(const Those& of, const Go& go);

  template <class Those>
  Pairs motion(const Those& of, const Outside<d, Several>& outside = {}) const {
    return {{law_, of_.scale.at(of)}, of_.reach.at(of), 1.0 / of_.mass.at(of), outside};
  }
  template <class Those>
  PairState<d, Several> state(const Those& of) const {
    return {of_.apart.at(of), of_.velocity.at(of)};
  }

  const Law& law_;
  ContactingGrains<d>& grains_;
  NearestImage<d> nearest_{Box<d>{}};
  double dt_ = 0;
  int touching_ = 0, count_ = 0;
  std::vector<Pair> pair_;  ///< slots of the grains
  PairColumns<d> of_;
};

template <int d, class Law>
void ContactRows<d, Law>::resize(int pairs) {
  count_ = pairs;
  const std::size_t whole = static_cast<std::size_t>(pairs + width - 1) / width * width;
  pair_.resize(whole, pairs > 0 ? pair_[pairs - 1] : Pair{});
  of_.table.resize(whole);
}

/// Returns grains at the start of step n. Without `flies` the grains are already at that step.
template <int d, class Law>
template <bool flies, class Slot>
auto ContactRows<d, Law>::seen(const Slot& slot, int n) const -> Seen {
  Seen s;
  s.per_mass = Several([&](int lane) { return grains_.grain(slot(lane)).per_mass; });
  const Several t([&](int lane) { return flies ? (n - grains_.grain(slot(lane)).followed_to) * dt_ : 0; });
  for (int k = 0; k < d; ++k) {
    s.place[k] = Several([&](int lane) { return grains_.grain(slot(lane)).place[k]; });
    Several momentum([&](int lane) { return grains_.grain(slot(lane)).momentum[k]; });
    if constexpr (flies) {
      Several force = 0;
      if (grains_.are_held()) force = Several([&](int lane) { return grains_.held(slot(lane))[k]; });
      fly(s.place[k], momentum, force, s.per_mass, t);
    }
    s.velocity[k] = momentum * s.per_mass;
  }
  return s;
}

template <int d, class Law>
PairState<d, Several> ContactRows<d, Law>::between(const Seen& lower, const Seen& higher) const {
  PairState<d, Several> state;
  for (int k = 0; k < d; ++k) {
    const Several x = higher.place[k] - lower.place[k];
    state.apart[k] = x - nearest_.length[k] * nearbyint(x * nearest_.turns_a_metre[k]);
    state.velocity[k] = higher.velocity[k] - lower.velocity[k];
  }
  return state;
}

template <int d, class Law>
template <bool flies>
[[gnu::flatten]] void ContactRows<d, Law>::see(Row row, int n) {
  const Seen lower = seen<flies>([&](int lane) { return pair_[row[lane]].i; }, n);
  const Seen higher = seen<flies>([&](int lane) { return pair_[row[lane]].j; }, n);
  const auto state = between(lower, higher);
  const Several radius_i([&](int lane) { return grains_.felt(pair_[row[lane]].i).radius; });
  const Several radius_j([&](int lane) { return grains_.felt(pair_[row[lane]].j).radius; });
  const Several reach = radius_i + radius_j;
  of_.apart.put(row, state.apart);
  of_.velocity.put(row, state.velocity);
  of_.lower.put(row, lower.per_mass);
  of_.higher.put(row, higher.per_mass);
  of_.reach.put(row, reach);
  of_.mass.put(row, 1.0 / (lower.per_mass + higher.per_mass));
  of_.scale.put(row, law_.scale(radius_i, radius_j));
  of_.overlap.put(row, reach - sqrt(norm2(state.apart)));
}

template <int d, class Law>
[[gnu::flatten]] void ContactRows<d, Law>::push(Row row) {
  const auto touching = of_.age.at(row) >= 0;
  of_.force.put(row, chosen<d, Several>(touching, motion(row).force(state(row)), {}));
  of_.stored.put(row, law_.push(not_below<Several>(of_.overlap.at(row), 0), of_.scale.at(row)).stored);
}

template <int d, class Law>
template <class SlotsOf, class SinceOf>
void ContactRows<d, Law>::look(int touching, const SlotsOf& slots_of, const SinceOf& since_of, double time,
                               bool all_touch, parallel::Team& team) {
  touching_ = touching;
  pair_.clear();
  for (int p = 0; p < touching; ++p) pair_.push_back(slots_of(p));
  resize(touching);
  for_each_row(0, touching, team, [&](Row row) {
    see<false>(row, 0);
    const Several since([&](int lane) { return since_of(std::min(row[lane], touching - 1)); });
    // Rounding can shift an onset at the end of a step past the step boundary.
    const Several age = not_below<Several>(time - since, 0);
    const auto touch = of_.overlap.at(row) > 0 || age <= rounding * dt_;
    of_.age.put(row, all_touch ? age : chosen<Several>(touch, age, -1));
    push(row);
  });
}

template <int d, class Law>
template <class SlotsOf>
void ContactRows<d, Law>::add(int candidates, const SlotsOf& slots_of, int n, parallel::Team& team) {
  pair_.resize(touching_);
  for (int p = 0; p < candidates; ++p) pair_.push_back(slots_of(p));
  resize(touching_ + candidates);
  // New pairs fill the last row of the pairs in contact, which is computed again.
  for (std::size_t p = touching_; p < pair_.size(); ++p) of_.age[static_cast<int>(p)] = -1;
  for_each_row(touching_ / width * width, count_, team, [&](Row row) {
    see<true>(row, n);
    push(row);
  });
}

template <int d, class Law>
void ContactRows<d, Law>::add(Forces when, Pair pair, const Vec<d>& push) {
  auto &on_i = grains_.felt(pair.i).*when, &on_j = grains_.felt(pair.j).*when;
  for (int k = 0; k < d; ++k) on_i[k] -= push[k], on_j[k] += push[k];
}

/// Returns the forces on the lower and the higher grain of each pair.
template <int d, class Law>
template <class Those>
std::array<Vectors<d>, 2> ContactRows<d, Law>::felt(Forces when, const Those& of) const {
  const auto on = [&](int Pair::*which) {
    return Vectors<d>::each(
        [&](int k) { return Several([&](int lane) { return (grains_.felt(pair_[of[lane]].*which).*when)[k]; }); });
  };
  return {on(&Pair::i), on(&Pair::j)};
}
template <int d, class Law>
template <class Those>
Vectors<d> ContactRows<d, Law>::relative(const std::array<Vectors<d>, 2>& forces, const Those& of) const {
  return of_.higher.at(of) * forces[1] - of_.lower.at(of) * forces[0];
}

/// Sums the contact forces on each grain at the start and in the middle of the step. Positions in the middle follow
/// from the forces at the start.
template <int d, class Law>
void ContactRows<d, Law>::feel_each_other(parallel::Team& team) {
  for (int s = 0; s < grains_.slots(); ++s) {
    Felt& felt = grains_.felt(s);
    felt.start = felt.halfway = grains_.are_held() ? grains_.held(s) : std::array<double, d>{};
  }
  for (int p = 0; p < touching_; ++p) add(&Felt::start, pair_[p], of_.force[p]);
  const Several half = 0.5 * dt_;
  for_each_row(0, count_, team, [&](Row row) [[gnu::flatten]] {
    const Vectors<d> acceleration = relative(felt(&Felt::start, row), row);
    of_.outside.put(row, acceleration - (1.0 / of_.mass.at(row)) * of_.force.at(row));
    of_.halfway_force.put(row, motion(row).force(carried(state(row), acceleration, half)));
  });
  for (int p = 0; p < count_; ++p) add(&Felt::halfway, pair_[p], of_.halfway_force[p]);
}

/// The few pairs whose force ends within the step are collected and computed together.
template <int d, class Law>
void ContactRows<d, Law>::follow(parallel::Team& team) {
  feel_each_other(team);
  team.for_each((count_ + pairs_a_task - 1) / pairs_a_task, [&](int task) {
    std::array<int, pairs_a_task> ending;
    int endings = 0;
    for (int p = task * pairs_a_task; p < std::min(count_, (task + 1) * pairs_a_task); p += width) {
      const auto releases =
          follow_those(Row{p}, [&](const Pairs& pairs, auto& begun) { return pairs.advance(begun, dt_); });
      for (int lane = 0; any(releases) && lane < width; ++lane)
        if (releases[lane]) ending[endings++] = p + lane;
    }
    for (int e = 0; e < endings; e += width) {
      Picked picked;
      for (int lane = 0; lane < width; ++lane) picked.pairs[lane] = ending[std::min(e + lane, endings - 1)];
      follow_those(picked, [&](const Pairs& pairs, auto& begun) {
        begun.step = pairs.release_within(begun, dt_);
        return begun.moves;
      });
    }
  });
}

/// Integrates each pair separately, with the acceleration by all others linear in time.
template <int d, class Law>
template <class Those, class Go>
[[gnu::flatten]] auto ContactRows<d, Law>::follow_those(const Those& of, const Go& go) {
  const Several mass = of_.mass.at(of), dt = dt_;
  const PairState<d, Several> start = state(of);
  const Vectors<d> first = of_.outside.at(of);
  const auto halfway = felt(&Felt::halfway, of);
  const Vectors<d> middle = relative(halfway, of) - (1.0 / mass) * of_.halfway_force.at(of);
  const auto outside = outside_through<d, Several>(first, middle, dt_);
  const Pairs pairs = motion(of, outside);
  const Several age = of_.age.at(of);
  auto begun = pairs.begin(start, age >= 0, age, dt_);
  const auto result = go(pairs, begun);
  const PairStep<d, Several>& step = begun.step;
  const auto [impulse, shift] = transfer(start, step.end, outside, mass, dt);
  const Vectors<d> none{};  // avoids impulses by rounding
  of_.impulse.put(of, chosen<d, Several>(begun.moves, impulse, none));
  of_.shift.put(of, chosen<d, Several>(begun.moves, shift, none));
  const Several lower = of_.lower.at(of), higher = of_.higher.at(of);
  of_.felt.put(of, not_below<Several>(lower * lower * norm2(halfway[0]), higher * higher * norm2(halfway[1])));
  of_.dissipated.put(of, step.dissipated);
  of_.touched.put(of, step.touched);
  of_.impact_speed.put(of, step.impact_speed);
  return result;
}

template <int d, class Law>
double ContactRows<d, Law>::max_contact_acceleration() const {
  Several square = 0;
  for (int p = 0; p < count_; p += width) square = not_below<Several>(square, of_.felt.at(Row{p}));
  return std::sqrt(hmax(square));
}

/// Moves the grains in contact to the end of step n.
template <int d, class Law>
void ContactRows<d, Law>::move(int n) {
  for (int p = 0; p < count_; ++p) {
    const Pair later = pair_[std::min(p + ahead, count_ - 1)];
    grains_.prefetch(later.i);
    grains_.prefetch(later.j);
    if (!(of_.age[p] >= 0 || of_.touched[p] >= 0)) continue;
    const Vec<d> shift = of_.shift[p], impulse = of_.impulse[p];
    grains_.push(pair_[p].i, n + 1, -of_.lower[p], shift, -1, impulse);
    grains_.push(pair_[p].j, n + 1, of_.higher[p], shift, 1, impulse);
  }
}

}  // namespace lichtenberg::granular
