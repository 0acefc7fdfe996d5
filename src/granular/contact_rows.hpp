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

/// Columns (arrays) of the quantities of pairs of grains in a contact substep, in reduced units. The pairs are in
/// contact or may touch. The lower grain of a pair has the smaller index in the bodies.
template <int d>
struct PairColumns {
  Table table;
  Column reach{table}, mass{table}, scale{table};    ///< sum of radii, reduced mass, factor of the law for the radii
  Column lower{table}, higher{table};                ///< 1 / mass of the lower and the higher grain
  Column age{table}, overlap{table}, stored{table};  ///< time since onset (< 0: no contact); overlap; elastic energy
  VectorColumn<d> separation{table}, velocity{table};
  VectorColumn<d> force{table};                  ///< contact force on the higher grain at the start of the step
  VectorColumn<d> other_acceleration{table};     ///< relative acceleration by all other forces at the start
  VectorColumn<d> halfway_force{table};          ///< contact force on the higher grain in the middle of the step
  Column acceleration2{table};                   ///< square of the larger acceleration of the two in mid-step
  VectorColumn<d> impulse{table}, shift{table};  ///< of the contact on the higher grain; shift: displacement times mass
  /// Dissipated energy; time of onset within the step (< 0: none); closing speed at onset.
  Column dissipated{table}, onset{table}, impact_speed{table};

  /// Returns separation and relative velocity of a pair at the start of the substep.
  PairState<d> state(int pair) const { return {separation[pair], velocity[pair]}; }
};

/// Computes the relative motion of pairs of grains over one contact substep on the CPU. The first pairs are those in
/// contact, then follow candidate pairs (separate, but may touch). A SIMD vector computes several pairs at once.
/// Devices evaluate the formulas of pair_motion.hpp with one thread for each pair (device/contact_steps.hpp).
template <int d, class Law>
class ContactRows {
 public:
  ContactRows(const Law& law, ContactingGrains<d>& grains) : law_(law), grains_(grains) {}

  /// Sets the box and the length dt of the following steps (t0).
  void begin(const Box<d>& box, double dt) {
    nearest_ = NearestImage<d>(box);
    dt_ = dt;
  }
  /// Replaces all pairs by the pairs in contact, and computes their states and contact forces at `time` (t0).
  /// `touching`: number of pairs; slots_of(p): slots (indices of the copies in ContactingGrains) of the grains of pair
  /// p; since_of(p): time of its onset (t0). A contact without overlap is marked as ended, unless `all_touch` is true
  /// or its onset is at `time`. Forces are zero without overlap.
  template <class SlotsOf, class SinceOf>
  void update_touching(int touching, const SlotsOf& slots_of, const SinceOf& since_of, double time, bool all_touch,
                       parallel::Team& team);
  /// Replaces the candidate pairs, which are separate at the start of step n, and computes their states there.
  /// `candidates`: number of these pairs; slots_of(p): slots (indices of the copies in ContactingGrains) of the grains
  /// of pair p.
  template <class SlotsOf>
  void add(int candidates, const SlotsOf& slots_of, int n, parallel::Team& team);
  /// Computes the relative motion of all pairs to the end of the step, without moving the grains.
  void follow(parallel::Team& team);
  /// Moves the grains that are or come into contact in step n to its end, by the computed motion of their pairs.
  void move(int n);
  /// Returns the largest acceleration (reduced units) of a grain in the middle of the computed step, by contacts and
  /// slow forces. Grains without a pair are not included.
  double max_contact_acceleration() const;

  int touching() const { return touching_; }
  int count() const { return count_; }
  Pair slots(int pair) const { return pair_[pair]; }
  const PairColumns<d>& columns() const { return columns_; }

 private:
  static constexpr int pairs_a_task = 512;  ///< a multiple of any vector width
  static constexpr int ahead = ContactingGrains<d>::ahead;
  using GrainForces = typename ContactingGrains<d>::GrainForces;
  using Forces = std::array<double, d> GrainForces::*;
  /// Contact law with the factor of the forces for the radii of each pair in a vector.
  struct ScaledLaw {
    const Law& law;
    SimdPack scale;

    ContactForceTerms<SimdPack> operator()(const SimdPack& overlap) const { return law.force_terms(overlap, scale); }
  };
  using Pairs = PairMotion<d, ScaledLaw, SimdPack>;
  void resize(int pairs);
  /// Calls visit(row) for each row (`width` successive pairs) of the pairs first <= p < last, in parallel. `first` must
  /// be a multiple of `width`.
  template <class Visit>
  void for_each_row(int first, int last, parallel::Team& team, const Visit& visit) {
    team.for_each((last - first + pairs_a_task - 1) / pairs_a_task, [&](int task) {
      const int begin = first + task * pairs_a_task;
      for (int p = begin; p < std::min(last, begin + pairs_a_task); p += width) visit(Row{p});
    });
  }
  template <bool advances, class Slot>
  GrainPack<d> load_grains(const Slot& slot, int n) const;
  template <bool advances>
  void load_states(Row row, int n);
  void compute_forces(Row row);
  void sum_contact_forces(parallel::Team& team);
  void add(Forces when, Pair pair, const Vec<d>& force);
  template <class Indices>
  std::array<Vectors<d>, 2> grain_forces(Forces when, const Indices& of) const;
  template <class Indices>
  Vectors<d> relative(const std::array<Vectors<d>, 2>& forces, const Indices& of) const;
  template <class Indices, class Go>
  auto follow_pairs(const Indices& of, const Go& go);

  template <class Indices>
  Pairs motion(const Indices& of, const ExternalAcceleration<d, SimdPack>& external = {}) const {
    return {{law_, columns_.scale.at(of)}, columns_.reach.at(of), 1.0 / columns_.mass.at(of), external};
  }
  template <class Indices>
  PairState<d, SimdPack> state(const Indices& of) const {
    return {columns_.separation.at(of), columns_.velocity.at(of)};
  }

  const Law& law_;
  ContactingGrains<d>& grains_;
  NearestImage<d> nearest_{Box<d>{}};
  double dt_ = 0;
  int touching_ = 0, count_ = 0;
  std::vector<Pair> pair_;  ///< slots of the grains
  PairColumns<d> columns_;
};

template <int d, class Law>
void ContactRows<d, Law>::resize(int pairs) {
  count_ = pairs;
  const std::size_t whole = static_cast<std::size_t>(pairs + width - 1) / width * width;
  pair_.resize(whole, pairs > 0 ? pair_[pairs - 1] : Pair{});
  columns_.table.resize(whole);
}

/// Returns the states of the grains slot(lane) at the start of step n. If `advances` is false, the stored states are
/// those at the start of step n; otherwise the grains fly there without contact.
template <int d, class Law>
template <bool advances, class Slot>
GrainPack<d> ContactRows<d, Law>::load_grains(const Slot& slot, int n) const {
  GrainPack<d> s;
  s.per_mass = SimdPack([&](int lane) { return grains_.grain(slot(lane)).per_mass; });
  s.radius = SimdPack([&](int lane) { return grains_.forces(slot(lane)).radius; });
  const SimdPack t([&](int lane) { return advances ? (n - grains_.grain(slot(lane)).followed_to) * dt_ : 0; });
  for (int k = 0; k < d; ++k) {
    s.position[k] = SimdPack([&](int lane) { return grains_.grain(slot(lane)).position[k]; });
    SimdPack momentum([&](int lane) { return grains_.grain(slot(lane)).momentum[k]; });
    if constexpr (advances) {
      SimdPack force = 0;
      if (grains_.has_slow_forces()) force = SimdPack([&](int lane) { return grains_.slow_force(slot(lane))[k]; });
      fly(s.position[k], momentum, force, s.per_mass, t);
    }
    s.velocity[k] = momentum * s.per_mass;
  }
  return s;
}

template <int d, class Law>
template <bool advances>
[[gnu::flatten]] void ContactRows<d, Law>::load_states(Row row, int n) {
  const GrainPack<d> lower = load_grains<advances>([&](int lane) { return pair_[row[lane]].i; }, n);
  const GrainPack<d> higher = load_grains<advances>([&](int lane) { return pair_[row[lane]].j; }, n);
  const auto state = relative_state(lower, higher, nearest_);
  const SimdPack reach = lower.radius + higher.radius;
  columns_.separation.put(row, state.separation);
  columns_.velocity.put(row, state.velocity);
  columns_.lower.put(row, lower.per_mass);
  columns_.higher.put(row, higher.per_mass);
  columns_.reach.put(row, reach);
  columns_.mass.put(row, 1.0 / (lower.per_mass + higher.per_mass));
  columns_.scale.put(row, law_.scale(lower.radius, higher.radius));
  columns_.overlap.put(row, reach - sqrt(norm2(state.separation)));
}

template <int d, class Law>
[[gnu::flatten]] void ContactRows<d, Law>::compute_forces(Row row) {
  const auto touching = columns_.age.at(row) >= 0;
  columns_.force.put(row, chosen<d, SimdPack>(touching, motion(row).force(state(row)), {}));
  columns_.stored.put(
      row, law_.force_terms(not_below<SimdPack>(columns_.overlap.at(row), 0), columns_.scale.at(row)).stored);
}

template <int d, class Law>
template <class SlotsOf, class SinceOf>
void ContactRows<d, Law>::update_touching(int touching, const SlotsOf& slots_of, const SinceOf& since_of, double time,
                                          bool all_touch, parallel::Team& team) {
  touching_ = touching;
  pair_.clear();
  for (int p = 0; p < touching; ++p) pair_.push_back(slots_of(p));
  resize(touching);
  for_each_row(0, touching, team, [&](Row row) {
    load_states<false>(row, 0);
    const SimdPack since([&](int lane) { return since_of(std::min(row[lane], touching - 1)); });
    // Rounding can shift an onset at the end of a step past the step boundary.
    const SimdPack age = not_below<SimdPack>(time - since, 0);
    const auto touch = columns_.overlap.at(row) > 0 || age <= rounding * dt_;
    columns_.age.put(row, all_touch ? age : chosen<SimdPack>(touch, age, -1));
    compute_forces(row);
  });
}

template <int d, class Law>
template <class SlotsOf>
void ContactRows<d, Law>::add(int candidates, const SlotsOf& slots_of, int n, parallel::Team& team) {
  pair_.resize(touching_);
  for (int p = 0; p < candidates; ++p) pair_.push_back(slots_of(p));
  resize(touching_ + candidates);
  // New pairs fill the last row of the pairs in contact, which is computed again.
  for (std::size_t p = touching_; p < pair_.size(); ++p) columns_.age[static_cast<int>(p)] = -1;
  for_each_row(touching_ / width * width, count_, team, [&](Row row) {
    load_states<true>(row, n);
    compute_forces(row);
  });
}

template <int d, class Law>
void ContactRows<d, Law>::add(Forces when, Pair pair, const Vec<d>& force) {
  auto &on_i = grains_.forces(pair.i).*when, &on_j = grains_.forces(pair.j).*when;
  for (int k = 0; k < d; ++k) on_i[k] -= force[k], on_j[k] += force[k];
}

/// Returns the total forces on the lower and the higher grain of each pair, at the start or middle of the step
/// (`when`).
template <int d, class Law>
template <class Indices>
std::array<Vectors<d>, 2> ContactRows<d, Law>::grain_forces(Forces when, const Indices& of) const {
  const auto on = [&](int Pair::*which) {
    return Vectors<d>::each(
        [&](int k) { return SimdPack([&](int lane) { return (grains_.forces(pair_[of[lane]].*which).*when)[k]; }); });
  };
  return {on(&Pair::i), on(&Pair::j)};
}
template <int d, class Law>
template <class Indices>
Vectors<d> ContactRows<d, Law>::relative(const std::array<Vectors<d>, 2>& forces, const Indices& of) const {
  return columns_.higher.at(of) * forces[1] - columns_.lower.at(of) * forces[0];
}

/// Sums the slow force and the contact forces on each grain with a slot, at the start and in the middle of the step.
/// Positions in the middle follow from the forces at the start.
template <int d, class Law>
void ContactRows<d, Law>::sum_contact_forces(parallel::Team& team) {
  for (int s = 0; s < grains_.slots(); ++s) {
    GrainForces& forces = grains_.forces(s);
    forces.start = forces.halfway = grains_.has_slow_forces() ? grains_.slow_force(s) : std::array<double, d>{};
  }
  for (int p = 0; p < touching_; ++p) add(&GrainForces::start, pair_[p], columns_.force[p]);
  const SimdPack half = 0.5 * dt_;
  for_each_row(0, count_, team, [&](Row row) [[gnu::flatten]] {
    const Vectors<d> acceleration = relative(grain_forces(&GrainForces::start, row), row);
    columns_.other_acceleration.put(row, acceleration - (1.0 / columns_.mass.at(row)) * columns_.force.at(row));
    columns_.halfway_force.put(row, motion(row).force(accelerated(state(row), acceleration, half)));
  });
  for (int p = 0; p < count_; ++p) add(&GrainForces::halfway, pair_[p], columns_.halfway_force[p]);
}

/// Computes the relative motion of all pairs over the step. The few pairs whose contact force ends within the step are
/// collected and computed together.
template <int d, class Law>
void ContactRows<d, Law>::follow(parallel::Team& team) {
  sum_contact_forces(team);
  team.for_each((count_ + pairs_a_task - 1) / pairs_a_task, [&](int task) {
    std::array<int, pairs_a_task> ending;
    int endings = 0;
    for (int p = task * pairs_a_task; p < std::min(count_, (task + 1) * pairs_a_task); p += width) {
      const auto releases =
          follow_pairs(Row{p}, [&](const Pairs& pairs, auto& begun) { return pairs.advance(begun, dt_); });
      for (int lane = 0; any(releases) && lane < width; ++lane)
        if (releases[lane]) ending[endings++] = p + lane;
    }
    for (int e = 0; e < endings; e += width) {
      SelectedPairs selected;
      for (int lane = 0; lane < width; ++lane) selected.pairs[lane] = ending[std::min(e + lane, endings - 1)];
      follow_pairs(selected, [&](const Pairs& pairs, auto& begun) {
        begun.step = pairs.release_within(begun, dt_);
        return begun.moves;
      });
    }
  });
}

/// Integrates a SIMD vector of pairs over the step, each pair on its own, and stores the results in the columns.
/// The function go(motion, begun) completes the step from `begun`, the motion up to the onset of the contact
/// (PartialStep). The relative acceleration by all other forces is linear in time. Returns the result of `go`.
template <int d, class Law>
template <class Indices, class Go>
[[gnu::flatten]] auto ContactRows<d, Law>::follow_pairs(const Indices& of, const Go& go) {
  const SimdPack mass = columns_.mass.at(of), dt = dt_;
  const PairState<d, SimdPack> start = state(of);
  const Vectors<d> first = columns_.other_acceleration.at(of);
  const auto halfway = grain_forces(&GrainForces::halfway, of);
  const Vectors<d> middle = relative(halfway, of) - (1.0 / mass) * columns_.halfway_force.at(of);
  const auto external = external_from_values<d, SimdPack>(first, middle, dt_);
  const Pairs pairs = motion(of, external);
  const SimdPack age = columns_.age.at(of);
  auto begun = pairs.begin(start, age >= 0, age, dt_);
  const auto result = go(pairs, begun);
  const PairStep<d, SimdPack>& step = begun.step;
  const auto [impulse, shift] = transfer(start, step.end, external, mass, dt);
  const Vectors<d> none{};  // avoids impulses by rounding
  columns_.impulse.put(of, chosen<d, SimdPack>(begun.moves, impulse, none));
  columns_.shift.put(of, chosen<d, SimdPack>(begun.moves, shift, none));
  const SimdPack lower = columns_.lower.at(of), higher = columns_.higher.at(of);
  columns_.acceleration2.put(
      of, not_below<SimdPack>(lower * lower * norm2(halfway[0]), higher * higher * norm2(halfway[1])));
  columns_.dissipated.put(of, step.dissipated);
  columns_.onset.put(of, step.onset);
  columns_.impact_speed.put(of, step.impact_speed);
  return result;
}

template <int d, class Law>
double ContactRows<d, Law>::max_contact_acceleration() const {
  SimdPack square = 0;
  for (int p = 0; p < count_; p += width) square = not_below<SimdPack>(square, columns_.acceleration2.at(Row{p}));
  return std::sqrt(hmax(square));
}

template <int d, class Law>
void ContactRows<d, Law>::move(int n) {
  for (int p = 0; p < count_; ++p) {
    const Pair later = pair_[std::min(p + ahead, count_ - 1)];
    grains_.prefetch(later.i);
    grains_.prefetch(later.j);
    if (!(columns_.age[p] >= 0 || columns_.onset[p] >= 0)) continue;
    const Vec<d> shift = columns_.shift[p], impulse = columns_.impulse[p];
    grains_.apply_contact(pair_[p].i, n + 1, -columns_.lower[p], shift, -1, impulse);
    grains_.apply_contact(pair_[p].j, n + 1, columns_.higher[p], shift, 1, impulse);
  }
}

}  // namespace lichtenberg::granular
