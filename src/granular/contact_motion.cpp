#include "src/granular/contact_motion.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "src/granular/contacts.hpp"
#include "src/granular/encounters.hpp"
#include "src/granular/pair_motion.hpp"

namespace lichtenberg::granular {
namespace {

/// A law for the two grains of each contact.
template <class Law>
struct OfPairs {
  const Law& law;
  Several scale;

  ContactPush<Several> operator()(const Several& overlap) const { return law.push(overlap, scale); }
};

template <int d, class Law>
class Motion final : public ContactMotion {
 public:
  explicit Motion(const Law& law) : law_(law) {}

  ContactsFollowed advance(Bodies& bodies, std::vector<GrainContact>& contacts, std::span<const double> held,
                           const ContactSteps& of, parallel::Team& team) override {
    const double time = of.begin, dt = of.time;
    ContactsFollowed followed{.record = {.time = time + dt, .dt = dt}};
    steps_ = of.steps;
    dt_ = dt / steps_;
    nearest_ = NearestImage<d>(spheres<d>(bodies).box);
    begin(bodies, held, contacts);
    encounters_.jolt(of.kicked + of.gain);
    for (int n = 0; n < steps_; ++n) {
      look(time + n * dt_, n == 0, team);
      if (n == 0)
        followed.stored_at_start = total(stored_, touching_);
      else
        note(time + n * dt_, followed.record);
      if (!encounters_.cover(dt_, of.fastest)) search(of, n, team), ++followed.searches;
      step(n, time + n * dt_, team, followed.record);
    }
    look(time + dt, false, team);
    followed.stored_at_end = total(stored_, touching_);
    followed.fastest_release = fastest_release();
    note(time + dt, followed.record);
    close();
    fly(bodies, steps_, team);
    contacts.clear();
    for (const Open& one : open_) contacts.push_back(one.contact);
    followed.record.open = contacts;
    return followed;
  }

 private:
  static constexpr int pairs_a_task = 512;  ///< a multiple of any width
  static constexpr int grains_a_task = 4096;
  static constexpr int ahead = 16;  ///< pairs or grains, of which memory is asked for early
  using Pairs = PairMotion<d, OfPairs<Law>, Several>;
  /// A grain as it was when a contact last pushed it, or at the start; in one line of a cache.
  struct alignas(64) Grain {
    std::array<double, d> place, momentum;
    double per_mass = 0;
    std::int32_t followed_to = 0;  ///< the step at whose beginning it was so
    std::int32_t particle = 0;
  };
  /// What its pairs need of a grain, all forces on it at the start and in the middle of a step; in one line too.
  struct alignas(64) Felt {
    std::array<double, d> start, halfway;
    double radius = 0;
    std::int32_t touches = 0;
  };
  struct Made {
    double per_mass = 0, radius = 0;
  };
  struct Open {
    GrainContact contact;
    Pair slots;
  };
  /// A pair that is apart.
  struct Apart {
    Pair pair, slots;
  };

  /// Grains that are in contact get slots, in the order of the contacts; all others stay what they are in `bodies`
  /// until somebody looks at them.
  void begin(const Bodies& bodies, std::span<const double> held, std::span<const GrainContact> contacts) {
    bodies_ = &bodies;
    held_forces_ = held;
    if (made_.empty()) {  // they stay what they are
      for (int i = 0; i < bodies.size(); ++i) made_.push_back({1 / bodies.mass[i], bodies.radius[i]});
      slot_.assign(bodies.size(), -1);
    }
    for (const Grain& grain : grains_) slot_[grain.particle] = -1;
    grains_.clear();
    felt_.clear();
    held_.clear();
    open_.clear();
    for (std::size_t p = 0; p < contacts.size(); ++p) {
      const Pair pair = contacts[p].pair;
      prefetch(contacts[std::min(p + ahead, contacts.size() - 1)].pair);
      open_.push_back({contacts[p], {slot_of(pair.i), slot_of(pair.j)}});
      ++felt_[open_.back().slots.i].touches, ++felt_[open_.back().slots.j].touches;
    }
  }
  void prefetch(Pair pair) const {
    for (const int i : {pair.i, pair.j}) {
      __builtin_prefetch(&bodies_->position[i * d]);
      __builtin_prefetch(&bodies_->momentum[i * d]);
      __builtin_prefetch(&made_[i]);
      __builtin_prefetch(&slot_[i]);
    }
  }
  int slot_of(int particle) {
    int& slot = slot_[particle];
    if (slot >= 0) return slot;
    slot = static_cast<int>(grains_.size());
    Grain& grain = grains_.emplace_back();
    for (int k = 0; k < d; ++k) {
      grain.place[k] = bodies_->position[particle * d + k];
      grain.momentum[k] = bodies_->momentum[particle * d + k];
    }
    grain.per_mass = made_[particle].per_mass;
    grain.particle = particle;
    felt_.push_back({.radius = made_[particle].radius});
    if (held_forces_.empty()) return slot;
    auto& held = held_.emplace_back();
    for (int k = 0; k < d; ++k) held[k] = held_forces_[particle * d + k];
    return slot;
  }

  /// Looks for the pairs that may touch from step n on until the fastest has flown its way.
  void search(const ContactSteps& of, int n, parallel::Team& team) {
    constexpr int most_steps = 64;
    constexpr double least = 0.1, more = 1.5;  // of what contacts might push with at most, and than they have
    const double kicked = of.gain + (std::isfinite(of.kicked) ? of.kicked : 0);
    const auto horizon = [&](double speed) { return std::max(dt_, std::min(of.way / speed, most_steps * dt_)); };
    const double jolt = kicked * std::max(1.0, std::ceil(horizon(of.fastest) / of.time) + 1);
    const double hardest = largest_acceleration(2 * (of.fastest + jolt));
    const double acceleration = 2 * std::max(least * hardest, more * encounters_.hardest_push());
    const Bounds bounds{
        .fastest = of.fastest + jolt, .jolt = jolt, .acceleration = acceleration, .excess = hardest * dt_ * dt_};
    hardest_ = hardest;
    const auto open = [&](Pair pair) { return is_open(pair); };
    const auto search_in = [&](const Bodies& bodies) {
      encounters_.search(bodies, bounds, (1 + rounding) * horizon(bounds.fastest), dt_, open, team);
    };
    if (n == 0) {
      search_in(*bodies_);
    } else {
      Bodies now = *bodies_;
      fly(now, n, team);
      search_in(now);
    }
    encounters_.jolt(of.gain);
  }
  /// What contacts may accelerate a grain by.
  double largest_acceleration(double speed) const {
    const double widest = *std::ranges::max_element(bodies_->radius), scale = law_.scale(widest, widest);
    const double lightest = *std::ranges::min_element(bodies_->mass);
    // The overlap that stores all that two have; its spring and its dashpot never act together like that.
    double low = 0, high = 2 * widest;
    for (int k = 0; k < 50; ++k) {
      const double middle = 0.5 * (low + high);
      (law_.parts(middle, scale).stored < 0.5 * lightest * speed * speed ? low : high) = middle;
    }
    const ContactParts deepest = law_.parts(high, scale);
    return (deepest.elastic + deepest.damping * speed) / lightest;
  }
  bool is_open(Pair pair) const {
    if (slot_[pair.i] < 0 || slot_[pair.j] < 0) return false;  // those of a contact have
    const auto found = std::ranges::lower_bound(open_, pair, {}, [](const Open& one) { return one.contact.pair; });
    return found != open_.end() && found->contact.pair == pair;
  }

  /// Brings bodies from the start to step n: those that nobody looked at fly in one go.
  void fly(Bodies& bodies, int n, parallel::Team& team) const {
    const double t = n * dt_;
    for_each_range(bodies.size(), team, [&](int first, int last) {
      for (int i = first; i < last; ++i) {
        const double path = t * made_[i].per_mass;
        for (int k = i * d; k < (i + 1) * d; ++k) {
          double& momentum = bodies.momentum[k];
          if (held_forces_.empty()) {
            bodies.position[k] += path * momentum;
          } else {
            bodies.position[k] += path * (momentum + 0.5 * t * held_forces_[k]);
            momentum += t * held_forces_[k];
          }
        }
      }
    });
    const int slots = static_cast<int>(grains_.size());
    for_each_range(slots, team, [&](int first, int last) {
      for (int s = first; s < last; ++s) {
        const int later = grains_[std::min(s + ahead, slots - 1)].particle;
        __builtin_prefetch(&bodies.position[later * d], 1);
        __builtin_prefetch(&bodies.momentum[later * d], 1);
        const Grain grain = flown(s, n);
        for (int k = 0; k < d; ++k) {
          bodies.position[grain.particle * d + k] = grain.place[k];
          bodies.momentum[grain.particle * d + k] = grain.momentum[k];
        }
      }
    });
  }
  template <class Visit>
  static void for_each_range(int count, parallel::Team& team, const Visit& visit) {
    team.for_each((count + grains_a_task - 1) / grains_a_task,
                  [&](int task) { visit(task * grains_a_task, std::min(count, (task + 1) * grains_a_task)); });
  }
  /// A grain at the beginning of step n that no contact pushes before.
  Grain flown(int slot, int n) const {
    Grain grain = grains_[slot];
    const double t = (n - grain.followed_to) * dt_, path = t * grain.per_mass;
    grain.followed_to = n;
    if (held_.empty()) {
      for (int k = 0; k < d; ++k) grain.place[k] += path * grain.momentum[k];
      return grain;
    }
    for (int k = 0; k < d; ++k) {
      grain.place[k] += path * (grain.momentum[k] + 0.5 * t * held_[slot][k]);
      grain.momentum[k] += t * held_[slot][k];
    }
    return grain;
  }

  /// Those that have parted are waited for again.
  void close() {
    int p = 0;
    std::erase_if(open_, [&](const Open& one) {
      const bool parted = !(age_[p++] >= 0);
      if (parted) encounters_.wait(one.contact.pair, 0);
      return parted;
    });
  }
  double fastest_release() const {
    double square = 0;
    for (int p = 0; p < touching_; ++p) square = std::max(square, 2 * stored_[p] / mass_[p]);
    return std::sqrt(square);
  }

  /// Pairs in the order of the contacts, then those that may come to it.
  void resize(std::size_t pairs) {
    pair_.resize(pairs);
    const std::size_t whole = (pairs + width - 1) / width * width;
    pair_.resize(whole, pairs > 0 ? pair_[pairs - 1] : Pair{});
    table_.resize(whole);
  }

  /// Calls visit(row) for those from `first` on, a multiple of the width.
  template <class Visit>
  void for_each_row(int first, int last, parallel::Team& team, const Visit& visit) {
    team.for_each((last - first + pairs_a_task - 1) / pairs_a_task, [&](int task) {
      const int begin = first + task * pairs_a_task;
      for (int p = begin; p < std::min(last, begin + pairs_a_task); p += width) visit(Row{p});
    });
  }

  /// Of the pairs that are apart, those that may touch in step n, in ascending order.
  void meet(int n) {
    meeting_.clear();
    due_.clear();
    encounters_.take(dt_, due_);
    // Within one step contacts may push as hard as they can.
    Bounds at_once = encounters_.bounds();
    at_once.acceleration = 2 * hardest_;
    at_once.excess = 0;
    const int count = static_cast<int>(due_.size());
    for (int first = 0; first < count; first += width) {
      for (int p = first + ahead; p < std::min(first + ahead + width, count); ++p) prefetch(due_[p]);
      const Glance glance = glance_at(first, n);
      const Several apart = apart_for<d>(glance.state, glance.reach, encounters_.bounds());
      const Several at_least = apart_for<d>(glance.state, glance.reach, at_once);
      for (int lane = 0; lane < std::min(width, count - first); ++lane) {
        const Pair pair = due_[first + lane];
        if (at_least[lane] < (1 + rounding) * dt_)
          meeting_.push_back({pair, {slot_of(pair.i), slot_of(pair.j)}});
        else
          encounters_.wait(pair, std::max<double>(apart[lane], dt_));
      }
    }
    std::ranges::sort(meeting_, {}, &Apart::pair);
  }
  struct Glance {
    PairState<d, Several> state;
    Several reach;
  };
  /// The pairs of `due_` from `first` on at the beginning of step n. Grains get no slots by that.
  Glance glance_at(int first, int n) const {
    std::array<std::array<double, width>, 2 * d + 1> found;
    for (int lane = 0; lane < width; ++lane) {
      const Pair pair = due_[std::min<std::size_t>(first + lane, due_.size() - 1)];
      const Grain lower = grain_at(pair.i, n), higher = grain_at(pair.j, n);
      for (int k = 0; k < d; ++k) {
        found[k][lane] = nearest_(higher.place[k] - lower.place[k], k);
        found[d + k][lane] = higher.per_mass * higher.momentum[k] - lower.per_mass * lower.momentum[k];
      }
      found[2 * d][lane] = made_[pair.i].radius + made_[pair.j].radius;
    }
    const auto of = [&](int which) { return Several(found[which].data(), anywhere); };
    return {{Vectors<d>::each([&](int k) { return of(k); }), Vectors<d>::each([&](int k) { return of(d + k); })},
            of(2 * d)};
  }
  Grain grain_at(int particle, int n) const {
    if (const int slot = slot_[particle]; slot >= 0) return flown(slot, n);
    Grain grain{.per_mass = made_[particle].per_mass};
    const double t = n * dt_, path = t * grain.per_mass;
    for (int k = 0; k < d; ++k) {
      const double held = held_forces_.empty() ? 0 : held_forces_[particle * d + k];
      const double momentum = bodies_->momentum[particle * d + k];
      grain.place[k] = bodies_->position[particle * d + k] + path * (momentum + 0.5 * t * held);
      grain.momentum[k] = momentum + t * held;
    }
    return grain;
  }

  /// One grain of each of several pairs.
  struct Seen {
    Vectors<d> place, velocity;
    Several per_mass;
  };
  /// At the beginning of step n; not `flies`: those that contacts have been followed to it for.
  template <bool flies, class Slot>
  Seen seen(const Slot& slot, int n) const {
    Seen s;
    s.per_mass = Several([&](int lane) { return grains_[slot(lane)].per_mass; });
    const Several t([&](int lane) { return flies ? (n - grains_[slot(lane)].followed_to) * dt_ : 0; });
    for (int k = 0; k < d; ++k) {
      s.place[k] = Several([&](int lane) { return grains_[slot(lane)].place[k]; });
      Several momentum([&](int lane) { return grains_[slot(lane)].momentum[k]; });
      if constexpr (flies) {
        Several force = 0;
        if (!held_.empty()) force = Several([&](int lane) { return held_[slot(lane)][k]; });
        s.place[k] += t * s.per_mass * (momentum + 0.5 * t * force);
        momentum += t * force;
      }
      s.velocity[k] = momentum * s.per_mass;
    }
    return s;
  }
  PairState<d, Several> between(const Seen& lower, const Seen& higher) const {
    PairState<d, Several> state;
    for (int k = 0; k < d; ++k) {
      const Several x = higher.place[k] - lower.place[k];
      state.apart[k] = x - nearest_.length[k] * nearbyint(x * nearest_.turns_a_metre[k]);
      state.velocity[k] = higher.velocity[k] - lower.velocity[k];
    }
    return state;
  }

  /// Where the pairs in contact are, and the force on each: zero on those that have parted.
  void look(double time, bool all_touch, parallel::Team& team) {
    touching_ = static_cast<int>(open_.size());
    pair_.clear();
    for (const Open& one : open_) pair_.push_back(one.slots);
    resize(touching_);
    for_each_row(0, touching_, team, [&](Row row) {
      see<false>(row, 0);
      const Several since([&](int lane) { return open_[std::min(row[lane], touching_ - 1)].contact.since; });
      // One that touched at the end of the step before may, by rounding, have done so later than now, or not yet.
      const Several age = not_below<Several>(time - since, 0);
      const auto touching = overlap_.at(row) > 0 || age <= rounding * dt_;
      age_.put(row, all_touch ? age : chosen<Several>(touching, age, -1));
      push(row);
    });
  }
  template <bool flies>
  [[gnu::flatten]] void see(Row row, int n) {
    const Seen lower = seen<flies>([&](int lane) { return pair_[row[lane]].i; }, n);
    const Seen higher = seen<flies>([&](int lane) { return pair_[row[lane]].j; }, n);
    const auto state = between(lower, higher);
    const Several radius_i([&](int lane) { return felt_[pair_[row[lane]].i].radius; });
    const Several radius_j([&](int lane) { return felt_[pair_[row[lane]].j].radius; });
    const Several reach = radius_i + radius_j;
    apart_.put(row, state.apart);
    velocity_.put(row, state.velocity);
    lower_.put(row, lower.per_mass);
    higher_.put(row, higher.per_mass);
    reach_.put(row, reach);
    mass_.put(row, 1.0 / (lower.per_mass + higher.per_mass));
    scale_.put(row, law_.scale(radius_i, radius_j));
    overlap_.put(row, reach - sqrt(norm2(state.apart)));
  }
  template <class Those>
  Pairs motion(const Those& of, const Outside<d, Several>& outside = {}) const {
    return {{law_, scale_.at(of)}, reach_.at(of), mass_.at(of), outside};
  }
  template <class Those>
  PairState<d, Several> state(const Those& of) const {
    return {apart_.at(of), velocity_.at(of)};
  }
  [[gnu::flatten]] void push(Row row) {
    const auto touching = age_.at(row) >= 0;
    const Vectors<d> force = chosen<d, Several>(touching, motion(row).force(state(row)), {});
    force_.put(row, force);
    stored_.put(row, law_.push(not_below<Several>(overlap_.at(row), 0), scale_.at(row)).stored);
  }

  /// Writes down what became of contacts until `time`.
  void note(double time, ContactRecord& record) {
    for (int p = 0; p < touching_; ++p) {
      const auto& [contact, slots] = open_[p];
      const double overlap = overlap_[p], sum = reach_[p];
      record.largest_overlap = std::max(record.largest_overlap, overlap / sum);
      const PairState<d> now{apart_[p], velocity_[p]};
      // What is still to be stored if they are to stop here, over what is.
      if (sum - overlap < too_close * sum)
        refuse_flight_through(contact, 1 + mass_[p] * closing(now) * closing(now) / 2 / stored_[p]);
      if (age_[p] >= 0) continue;
      record.ended.push_back({contact, -closing(now), time, speed_across(now)});
      --felt_[slots.i].touches, --felt_[slots.j].touches;
    }
  }

  void step(int n, double time, parallel::Team& team, ContactRecord& record) {
    add_meeting(n, team);
    feel_each_other(team);
    integrate(team);
    move(n);
    record.dissipated += total(dissipated_, touching_);
    for (int p = touching_; p < count_; ++p)
      if (touched_[p] >= 0) record.dissipated += dissipated_[p];
    encounters_.pass(dt_);
    begin_contacts(time, record);
  }

  /// Pairs that are apart and may come into contact.
  void add_meeting(int n, parallel::Team& team) {
    meet(n);
    pair_.clear();
    for (const Open& one : open_) pair_.push_back(one.slots);
    for (const Apart& one : meeting_) pair_.push_back(one.slots);
    count_ = static_cast<int>(pair_.size());
    resize(count_);
    for (int p = touching_; p < static_cast<int>(pair_.size()); ++p) age_[p] = -1;
    for_each_row(touching_ / width * width, count_, team, [&](Row row) {
      see<true>(row, n);
      push(row);
    });
  }

  /// The forces of contacts at the start and in the middle of the step, so that each knows what the others of its
  /// grains do. In the middle grains are where the forces at the start carry them.
  void feel_each_other(parallel::Team& team) {
    for (std::size_t s = 0; s < felt_.size(); ++s)
      felt_[s].start = felt_[s].halfway = held_.empty() ? std::array<double, d>{} : held_[s];
    for (int p = 0; p < touching_; ++p) add(&Felt::start, pair_[p], force_[p]);
    const double h = 0.5 * dt_;
    for_each_row(0, count_, team, [&](Row row) [[gnu::flatten]] {
      const Vectors<d> acceleration = relative(&Felt::start, row);
      const PairState<d, Several> now = state(row);
      const Several time = h, half_square = 0.5 * h * h;
      outside_.put(row, acceleration - (1.0 / mass_.at(row)) * force_.at(row));
      halfway_force_.put(row, motion(row).force({now.apart + time * now.velocity + half_square * acceleration,
                                                 now.velocity + time * acceleration}));
    });
    for (int p = 0; p < count_; ++p) add(&Felt::halfway, pair_[p], halfway_force_[p]);
    encounters_.push(hardest_push());
  }
  double hardest_push() const {
    double square = 0;
    for (std::size_t s = 0; s < grains_.size(); ++s) {
      double sum = 0;
      for (int k = 0; k < d; ++k) {
        const double force = felt_[s].halfway[k] - (held_.empty() ? 0 : held_[s][k]);
        sum += force * force;
      }
      square = std::max(square, sum * grains_[s].per_mass * grains_[s].per_mass);
    }
    return std::sqrt(square);
  }
  void add(std::array<double, d> Felt::*when, Pair pair, Vec<d> push) {
    auto &on_i = felt_[pair.i].*when, &on_j = felt_[pair.j].*when;
    for (int k = 0; k < d; ++k) on_i[k] -= push[k], on_j[k] += push[k];
  }
  template <class Those>
  Vectors<d> relative(std::array<double, d> Felt::*when, const Those& of) const {
    const Several lower = lower_.at(of), higher = higher_.at(of);
    return Vectors<d>::each([&](int k) {
      const Several on_higher([&](int lane) { return (felt_[pair_[of[lane]].j].*when)[k]; });
      const Several on_lower([&](int lane) { return (felt_[pair_[of[lane]].i].*when)[k]; });
      return on_higher * higher - on_lower * lower;
    });
  }

  /// Pairs whose force ends within the step, which are few, are computed together.
  void integrate(parallel::Team& team) {
    team.for_each((count_ + pairs_a_task - 1) / pairs_a_task, [&](int task) {
      std::array<int, pairs_a_task> ending;
      int endings = 0;
      for (int p = task * pairs_a_task; p < std::min(count_, (task + 1) * pairs_a_task); p += width) {
        const auto lets_go = follow(Row{p}, [&](const Pairs& pairs, auto& begun) { return pairs.go_on(begun, dt_); });
        for (int lane = 0; any(lets_go) && lane < width; ++lane)
          if (lets_go[lane]) ending[endings++] = p + lane;
      }
      for (int e = 0; e < endings; e += width) {
        Picked picked;
        for (int lane = 0; lane < width; ++lane) picked.pairs[lane] = ending[std::min(e + lane, endings - 1)];
        follow(picked, [&](const Pairs& pairs, auto& begun) {
          begun.step = pairs.let_go_within(begun, dt_);
          return begun.moves;
        });
      }
    });
  }
  /// Each pair by itself, with what the others give it linear in time.
  template <class Those, class Go>
  [[gnu::flatten]] auto follow(const Those& of, const Go& go) {
    const Several mass = mass_.at(of), dt = dt_;
    const PairState<d, Several> start = state(of);
    const Vectors<d> first = outside_.at(of);
    const Vectors<d> middle = relative(&Felt::halfway, of) - (1.0 / mass) * halfway_force_.at(of);
    const Outside<d, Several> outside{first, Several(2 / dt_) * (middle - first)};
    const Pairs pairs = motion(of, outside);
    const Several age = age_.at(of);
    auto begun = pairs.begin(start, age >= 0, age, dt_);
    const auto result = go(pairs, begun);
    const PairStep<d, Several>& step = begun.step;
    const Vectors<d> none{};  // not even an impulse of rounding
    impulse_.put(
        of, chosen<d, Several>(begun.moves, mass * (step.end.velocity - start.velocity - outside.velocity(dt)), none));
    shift_.put(
        of, chosen<d, Several>(begun.moves,
                               mass * (step.end.apart - start.apart - dt * start.velocity - outside.path(dt)), none));
    dissipated_.put(of, step.dissipated);
    touched_.put(of, step.touched);
    impact_speed_.put(of, step.impact_speed);
    return result;
  }

  /// Carries those that contacts push to the end of step n.
  void move(int n) {
    for (int p = 0; p < count_; ++p) {
      const Pair later = pair_[std::min(p + ahead, count_ - 1)];
      __builtin_prefetch(&grains_[later.i], 1);
      __builtin_prefetch(&grains_[later.j], 1);
      if (!(age_[p] >= 0 || touched_[p] >= 0)) continue;
      const Vec<d> shift = shift_[p], impulse = impulse_[p];
      push(pair_[p].i, n + 1, -lower_[p], shift, -1, impulse);
      push(pair_[p].j, n + 1, higher_[p], shift, 1, impulse);
    }
  }
  void push(int slot, int n, double by, const Vec<d>& shift, double sign, const Vec<d>& impulse) {
    Grain& grain = grains_[slot];
    if (grain.followed_to != n) grain = flown(slot, n);
    for (int k = 0; k < d; ++k) {
      grain.place[k] += by * shift[k];
      grain.momentum[k] += sign * impulse[k];
    }
  }

  /// Which contacts there are after a step that began at `time`: those that are open and those that have begun.
  void begin_contacts(double time, ContactRecord& record) {
    begun_.clear();
    for (int p = 0; p < count_; ++p) {
      if (age_[p] >= 0) continue;
      const Pair pair = p < touching_ ? open_[p].contact.pair : meeting_[p - touching_].pair;
      if (touched_[p] >= 0)
        begun_.push_back({{pair, time + touched_[p], impact_speed_[p]}, pair_[p]});
      else
        encounters_.wait(pair, 0);
    }
    int p = 0;
    std::erase_if(open_, [&](const Open&) { return !(age_[p++] >= 0); });
    if (begun_.empty()) return;
    for (const Open& one : begun_) ++felt_[one.slots.i].touches, ++felt_[one.slots.j].touches;
    const auto alone = [&](Pair slots) { return felt_[slots.i].touches == 1 && felt_[slots.j].touches == 1; };
    for (Open& one : begun_) one.contact.alone = alone(one.slots);
    for (Open& one : open_) one.contact.alone = one.contact.alone && alone(one.slots);
    const auto pair = [](const Open& one) { return one.contact.pair; };
    std::ranges::sort(begun_, {}, pair);
    for (const Open& one : begun_) record.begun.push_back(one.contact);
    sorted_.resize(open_.size() + begun_.size());
    std::ranges::merge(open_, begun_, sorted_.begin(), {}, pair, pair);
    open_.swap(sorted_);
  }

  Law law_;
  double dt_ = 0, hardest_ = 0;  ///< hardest: what contacts may accelerate a grain by
  int steps_ = 0, touching_ = 0, count_ = 0;
  Encounters<d> encounters_;
  NearestImage<d> nearest_{Box<d>{}};
  const Bodies* bodies_ = nullptr;       ///< as they are at the start
  std::span<const double> held_forces_;  ///< of all else, [N * d]; empty: none
  std::vector<Made> made_;               ///< by particle
  std::vector<int> slot_;                ///< by particle; -1: nobody has looked at it
  // By slot.
  std::vector<Grain> grains_;
  std::vector<Felt> felt_;                   ///< forces of those of pairs that are computed
  std::vector<std::array<double, d>> held_;  ///< empty: none

  std::vector<Pair> due_;
  std::vector<Apart> meeting_;
  std::vector<Open> open_, begun_, sorted_;

  // Of the pairs of slots that are computed in a step: those in contact in ascending order, then those that may come
  // to it.
  std::vector<Pair> pair_;
  Table table_;
  Column reach_{table_}, mass_{table_}, scale_{table_};    ///< mass: reduced
  Column lower_{table_}, higher_{table_};                  ///< 1 / mass of the two
  Column age_{table_}, overlap_{table_}, stored_{table_};  ///< age below 0: they do not touch
  VectorColumn<d> apart_{table_}, velocity_{table_},
      force_{table_};                                        ///< force: on the higher, at the start of the step
  VectorColumn<d> outside_{table_}, halfway_force_{table_};  ///< outside: acceleration by others, at the start
  VectorColumn<d> impulse_{table_}, shift_{table_};          ///< on the higher; shift: what it moves by, times its mass
  Column dissipated_{table_}, touched_{table_}, impact_speed_{table_};
};

}  // namespace

std::unique_ptr<ContactMotion> make_contact_motion(const GrainContactLaw& law, int dimension) {
  return std::visit(
      [&](const auto& one) -> std::unique_ptr<ContactMotion> {
        using Law = std::decay_t<decltype(one)>;
        if (dimension == 3) return std::make_unique<Motion<3, Law>>(one);
        return std::make_unique<Motion<2, Law>>(one);
      },
      law);
}

}  // namespace lichtenberg::granular
