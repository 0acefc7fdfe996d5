#include "src/granular/contact_motion.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <experimental/simd>
#include <numeric>
#include <utility>

#include "solvers/neighbours/cell_order.hpp"
#include "src/granular/contacts.hpp"
#include "src/granular/pair_motion.hpp"

namespace lichtenberg::granular {
namespace {

/// As many numbers as the processor computes with together. This file is compiled without contraction of products and
/// sums, so that a pair's result has the same bits in any lane and with any number of them.
using Several = std::experimental::native_simd<double>;
constexpr int width = Several::size();
constexpr auto anywhere = std::experimental::element_aligned;

/// Pairs that are computed together: they follow each other, or are picked.
struct Row {
  int first;
  int operator[](int lane) const { return first + lane; }
};
struct Picked {
  std::array<int, width> pairs;
  int operator[](int lane) const { return pairs[lane]; }
};

/// Columns of numbers of pairs. Those of a row of pairs lie together: loops over all columns read memory as it comes.
class Table {
 public:
  void resize(std::size_t pairs) { values_.resize(pairs * columns_); }
  int add_column() { return columns_++; }
  std::size_t place(int column, int pair) const {
    return (static_cast<std::size_t>(pair / width) * columns_ + column) * width + pair % width;
  }
  double* at(std::size_t place) { return &values_[place]; }
  const double* at(std::size_t place) const { return &values_[place]; }

 private:
  int columns_ = 0;
  std::vector<double> values_;
};

/// A number of each pair.
class Column {
 public:
  explicit Column(Table& table) : table_(&table), number_(table.add_column()) {}
  double& operator[](int pair) { return *table_->at(table_->place(number_, pair)); }
  double operator[](int pair) const { return *std::as_const(*table_).at(table_->place(number_, pair)); }

  Several at(Row row) const { return Several(std::as_const(*table_).at(table_->place(number_, row.first)), anywhere); }
  Several at(const Picked& of) const {
    return Several([&](int lane) { return (*this)[of[lane]]; });
  }
  void put(Row row, const Several& x) { x.copy_to(&(*this)[row.first], anywhere); }
  void put(const Picked& of, const Several& x) {
    for (int lane = 0; lane < width; ++lane) (*this)[of[lane]] = x[lane];
  }

 private:
  Table* table_;
  int number_;
};

template <int d>
using Vectors = LaneVec<d, Several>;

template <int d>
class VectorColumn {
 public:
  explicit VectorColumn(Table& table) {
    for (int k = 0; k < d; ++k) of_.emplace_back(table);
  }
  Vec<d> operator[](int pair) const {
    Vec<d> v;
    for (int k = 0; k < d; ++k) v[k] = of_[k][pair];
    return v;
  }
  template <class Those>
  Vectors<d> at(const Those& of) const {
    return Vectors<d>::each([&](int k) { return of_[k].at(of); });
  }
  template <class Those>
  void put(const Those& of, const Vectors<d>& x) {
    for (int k = 0; k < d; ++k) of_[k].put(of, x[k]);
  }

 private:
  std::vector<Column> of_;
};

/// The sum, in an order that is that of the numbers alone.
double total(const Column& of, int count) {
  std::array<double, 8> sums{};
  for (int p = 0; p < count; ++p) sums[p % 8] += of[p];
  return ((sums[0] + sums[4]) + (sums[2] + sums[6])) + ((sums[1] + sums[5]) + (sums[3] + sums[7]));
}

/// A law for the two grains of each contact.
template <class Law>
struct OfPairs {
  const Law& law;
  Several scale;

  ContactPush<Several> operator()(const Several& overlap) const { return law.push(overlap, scale); }
};

template <class Index>
Several of(const std::vector<double>& values, const Index& index) {
  return Several([&](int lane) { return values[index(lane)]; });
}

template <int d, class Law>
class Motion final : public ContactMotion {
 public:
  explicit Motion(const Law& law) : law_(law) {}

  ContactsFollowed advance(Bodies& bodies, std::vector<GrainContact>& contacts, const NearPairs& pairs,
                           std::span<const double> held, double time, double dt, int steps,
                           parallel::Team& team) override {
    ContactsFollowed followed{.record = {.time = time + dt, .dt = dt}};
    steps_ = steps;
    dt_ = dt / steps;
    bound(bodies, held);
    order(bodies, pairs.has_value());
    gather(bodies, held, team);
    open(contacts);
    due_.resize(steps_);
    for (auto& due : due_) due.clear();
    wait_from(0, pairs ? near_of(*pairs) : cells_.pairs(team), team);
    for (int n = 0; n < steps; ++n) {
      look(time + n * dt_, n == 0, team);
      if (n == 0)
        followed.stored_at_start = total(stored_, touching_);
      else
        note(time + n * dt_, followed.record);
      step(n, time + n * dt_, team, followed.record);
    }
    look(time + dt, false, team);
    followed.stored_at_end = total(stored_, touching_);
    note(time + dt, followed.record);
    close();
    give_back(bodies, team);
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
    float radius = 0;              ///< rounded up
  };
  /// What its pairs need of a grain, all forces on it at the start and in the middle of a step; in one line too.
  struct alignas(64) Felt {
    std::array<double, d> start, halfway;
    double radius = 0;
    std::int32_t touches = 0;
  };
  struct Open {
    GrainContact contact;
    Pair slots;
  };

  /// How fast grains become within `steps_`, and what contacts may accelerate two towards each other by.
  void bound(const Bodies& bodies, std::span<const double> held) {
    const double dt = dt_ * steps_, held_most = largest_over_mass(bodies, held);
    fastest_ = fastest(bodies) + held_most * dt;
    // Contacts may speed a grain up: twice the fastest is more than any has after a collision.
    speed_ = 2 * fastest_;
    if (grains_.empty()) {  // they stay what they are
      widest_ = *std::ranges::max_element(bodies.radius);
      lightest_ = *std::ranges::min_element(bodies.mass);
    }
    const double scale = law_.scale(widest_, widest_);
    // The overlap that stores all that two have; its spring and its dashpot never act together like that.
    double low = 0, high = 2 * widest_;
    for (int k = 0; k < 50; ++k) {
      const double middle = 0.5 * (low + high);
      (law_.parts(middle, scale).stored < 0.5 * lightest_ * speed_ * speed_ ? low : high) = middle;
    }
    const ContactParts deepest = law_.parts(high, scale);
    acceleration_ = (deepest.elastic + deepest.damping * speed_) / lightest_ + 2 * held_most;
  }
  /// How much closer two come within t than in straight flight, at most.
  double bend(double t) const { return std::min(0.5 * acceleration_ * t * t, 3 * speed_ * t); }

  /// How much closer than they are two may come within the steps.
  double approach() const {
    const double dt = dt_ * steps_;
    return std::min(2 * speed_ * dt, 2 * fastest_ * dt + bend(dt)) + rounding * widest_;
  }
  /// Which slot a grain has: in the order of cells or, where pairs are given, its own number.
  void order(const Bodies& bodies, bool as_they_are) {
    const Spheres<d> grains = spheres<d>(bodies);
    nearest_ = NearestImage<d>(grains.box);
    if (!as_they_are) {
      cells_.sort(grains, 2 * widest_ + approach());
      particle_ = cells_.particles();
      slot_ = cells_.slots();
      return;
    }
    same_.resize(bodies.size());
    std::iota(same_.begin(), same_.end(), 0);
    particle_ = slot_ = same_;
  }
  void gather(const Bodies& bodies, std::span<const double> held, parallel::Team& team) {
    const int n = bodies.size();
    grains_.resize(n);
    felt_.resize(n);
    held_.resize(held.empty() ? 0 : n);
    const double *position = bodies.position.data(), *momentum = bodies.momentum.data();
    for_each_grain(team, [&](int s) {
      const int i = particle_[s], later = particle_[std::min(s + ahead, n - 1)];
      __builtin_prefetch(&position[later * d]);
      __builtin_prefetch(&momentum[later * d]);
      Grain& grain = grains_[s];
      std::copy_n(&position[i * d], d, grain.place.begin());
      std::copy_n(&momentum[i * d], d, grain.momentum.begin());
      if (!held.empty()) std::copy_n(&held[i * d], d, held_[s].begin());
      grain.per_mass = 1 / bodies.mass[i];
      grain.followed_to = 0;
      grain.radius = std::nextafter(static_cast<float>(bodies.radius[i]), INFINITY);
      felt_[s].radius = bodies.radius[i];
      felt_[s].touches = 0;
    });
  }
  void give_back(Bodies& bodies, parallel::Team& team) const {
    const int n = bodies.size();
    for_each_grain(team, [&](int i) {
      __builtin_prefetch(&grains_[slot_[std::min(i + ahead, n - 1)]]);
      const Grain grain = flown(slot_[i], steps_);
      std::copy_n(grain.place.begin(), d, &bodies.position[i * d]);
      std::copy_n(grain.momentum.begin(), d, &bodies.momentum[i * d]);
    });
  }
  template <class Visit>
  void for_each_grain(parallel::Team& team, const Visit& visit) const {
    const int n = static_cast<int>(grains_.size());
    team.for_each((n + grains_a_task - 1) / grains_a_task, [&](int task) {
      for (int s = task * grains_a_task; s < std::min(n, (task + 1) * grains_a_task); ++s) visit(s);
    });
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

  /// Contacts in ascending order of slots.
  void open(std::span<const GrainContact> contacts) {
    open_.clear();
    for (const GrainContact& contact : contacts) {
      const auto [i, j] = contact.pair;
      open_.push_back({contact, {std::min(slot_[i], slot_[j]), std::max(slot_[i], slot_[j])}});
      ++felt_[slot_[i]].touches, ++felt_[slot_[j]].touches;
    }
    sort_pairs([](const Open& one) { return one.slots; });
  }
  /// Contacts that are open in ascending order of grains.
  void close() {
    int p = 0;
    std::erase_if(open_, [&](const Open&) { return !(age_[p++] >= 0); });
    const auto pair = [](const Open& one) { return one.contact.pair; };
    if (!std::ranges::is_sorted(open_, {}, pair)) sort_pairs(pair);
  }
  /// By counting: there are as many as grains.
  template <class Of>
  void sort_pairs(const Of& of) {
    first_.assign(grains_.size() + 1, 0);
    for (const Open& one : open_) ++first_[of(one).i + 1];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    sorted_.resize(open_.size());
    for (const Open& one : open_) sorted_[first_[of(one).i]++] = one;
    open_.swap(sorted_);
    for (std::size_t p = 1; p < open_.size(); ++p)  // those of one grain, a few
      for (std::size_t q = p; q > 0 && of(open_[q]) < of(open_[q - 1]); --q) std::swap(open_[q], open_[q - 1]);
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

  /// Those of the pairs that are near enough to touch.
  const std::vector<Pair>& near_of(std::span<const Pair> pairs) {
    near_.resize(pairs.size() + width);
    int count = 0;
    std::size_t p = 0;
    for (; p + width <= pairs.size(); p += width) {
      for (std::size_t q = p + ahead; q < std::min(p + ahead + width, pairs.size()); ++q)
        __builtin_prefetch(&grains_[pairs[q].j]);
      count += put_near(&pairs[p], &near_[count]);
    }
    for (; p < pairs.size(); ++p) near_[count++] = pairs[p];
    near_.resize(count);
    return near_;
  }
  /// Copies those of a row that are near, without branches: which ones is hard to guess. Returns how many.
  [[gnu::flatten]] int put_near(const Pair* row, Pair* to) const {
    const auto of = [&](const auto& value) {
      return std::pair{Several([&](int lane) { return value(grains_[row[lane].i]); }),
                       Several([&](int lane) { return value(grains_[row[lane].j]); })};
    };
    const auto [radius_i, radius_j] = of([](const Grain& grain) { return grain.radius; });
    const Several most = radius_i + radius_j + approach();
    Several distance2 = 0;
    for (int k = 0; k < d; ++k) {
      const auto [i, j] = of([k](const Grain& grain) { return grain.place[k]; });
      const Several x = j - i, r = x - nearest_.length[k] * nearbyint(x * nearest_.turns_a_metre[k]);
      distance2 += r * r;
    }
    const auto is_near = distance2 < most * most;
    int count = 0;
    for (int lane = 0; lane < width; ++lane) {
      to[count] = row[lane];
      count += is_near[lane];
    }
    return count;
  }
  /// For each of these pairs, which are apart, the step before which they cannot touch: those for which that is step n
  /// go to `meeting_`.
  void wait_from(int n, const std::vector<Pair>& pairs, parallel::Team& team) {
    meeting_.clear();
    pair_.assign(pairs.begin(), pairs.end());
    const int count = static_cast<int>(pairs.size());
    pair_.resize((count + width - 1) / width * width, count > 0 ? pairs.back() : Pair{});
    apart_for_.resize(pair_.size());
    for_each_row(0, count, team, [&](Row row) {
      (n == 0 ? steps_apart<false>(row, n) : steps_apart<true>(row, n)).copy_to(&apart_for_[row.first], anywhere);
    });
    for (int p = 0; p < count; ++p) {
      const int then = n + static_cast<int>(apart_for_[p]);
      if (then >= steps_) continue;
      if (then > n)
        due_[then].push_back(pair_[p]);
      else if (n > 0 || !is_open(pair_[p]))
        meeting_.push_back(pair_[p]);
    }
  }
  /// For how many steps from n on pairs stay apart. In straight flight two come closer never faster than at first, c,
  /// and contacts bring them a t^2 / 2 closer, or 3 `speed_` t: their gap lasts longer than either way has it closed.
  template <bool fly>
  [[gnu::flatten]] Several steps_apart(Row row, int n) const {
    for (int p = row.first + ahead; p < std::min(row.first + ahead + width, static_cast<int>(pair_.size())); ++p)
      __builtin_prefetch(&grains_[pair_[p].j]);
    const Seen lower = seen<fly>([&](int lane) { return pair_[row[lane]].i; }, n);
    const Seen higher = seen<fly>([&](int lane) { return pair_[row[lane]].j; }, n);
    const auto [r, v] = between(lower, higher);
    const Several radius_i([&](int lane) { return grains_[pair_[row[lane]].i].radius; });
    const Several radius_j([&](int lane) { return grains_[pair_[row[lane]].j].radius; });
    const Several distance = sqrt(norm2(r)), reach = (1 + rounding) * (radius_i + radius_j);
    const Several gap = not_below<Several>(distance - reach, 0), closing = not_below<Several>(-dot(r, v) / distance, 0);
    const Several bent = 2.0 * gap / (closing + sqrt(closing * closing + 2 * acceleration_ * gap));
    const Several time = not_below<Several>(bent, gap / (closing + 3 * speed_));
    return chosen<Several>(gap > 0, not_above<Several>(time * (1 / dt_), steps_), 0);
  }
  bool is_open(Pair slots) const {
    if (felt_[slots.i].touches == 0 || felt_[slots.j].touches == 0) return false;
    // Since it has sorted them, first_[i] is where contacts end of which i is the lower.
    for (int p = slots.i > 0 ? first_[slots.i - 1] : 0; p < first_[slots.i]; ++p)
      if (open_[p].slots == slots) return true;
    return false;
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
    record.dissipated += total(dissipated_, count_);
    begin_contacts(n, time, record);
  }

  /// Pairs that are apart and may come into contact.
  void add_meeting(int n, parallel::Team& team) {
    if (n > 0) wait_from(n, due_[n], team);
    pair_.clear();
    for (const Open& one : open_) pair_.push_back(one.slots);
    pair_.insert(pair_.end(), meeting_.begin(), meeting_.end());
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
    for (int p = 0; p < count_; ++p) {
      __builtin_prefetch(&felt_[pair_[std::min(p + ahead, count_ - 1)].j], 1);
      for (const int i : {pair_[p].i, pair_[p].j})
        for (int k = 0; k < d; ++k) felt_[i].start[k] = felt_[i].halfway[k] = held_.empty() ? 0 : held_[i][k];
    }
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

  /// Which contacts there are after step n: those that are open and those that have begun.
  void begin_contacts(int n, double time, ContactRecord& record) {
    begun_.clear();
    for (int p = 0; p < count_; ++p) {
      if (age_[p] >= 0) continue;
      if (touched_[p] >= 0) {
        const int i = particle_[pair_[p].i], j = particle_[pair_[p].j];
        begun_.push_back({{{std::min(i, j), std::max(i, j)}, time + touched_[p], impact_speed_[p]}, pair_[p]});
      } else if (n + 1 < steps_) {
        due_[n + 1].push_back(pair_[p]);
      }
    }
    int p = 0;
    std::erase_if(open_, [&](const Open&) { return !(age_[p++] >= 0); });
    if (begun_.empty()) return;
    for (const Open& one : begun_) ++felt_[one.slots.i].touches, ++felt_[one.slots.j].touches;
    const auto alone = [&](Pair slots) { return felt_[slots.i].touches == 1 && felt_[slots.j].touches == 1; };
    for (Open& one : begun_) one.contact.alone = alone(one.slots);
    for (Open& one : open_) one.contact.alone = one.contact.alone && alone(one.slots);
    std::ranges::sort(begun_, {}, [](const Open& one) { return one.contact.pair; });
    for (const Open& one : begun_) record.begun.push_back(one.contact);
    std::ranges::sort(begun_, {}, &Open::slots);
    sorted_.resize(open_.size() + begun_.size());
    std::ranges::merge(open_, begun_, sorted_.begin(), {}, &Open::slots, &Open::slots);
    open_.swap(sorted_);
  }

  static constexpr double rounding = 1e-9;  ///< more than that of places, less than what matters

  Law law_;
  double dt_ = 0, fastest_ = 0, speed_ = 0, acceleration_ = 0, widest_ = 0, lightest_ = 0;
  int steps_ = 0, touching_ = 0, count_ = 0;
  CellOrder<d> cells_;
  NearestImage<d> nearest_{Box<d>{}};
  std::span<const int> particle_, slot_;  ///< by slot, by particle
  std::vector<int> same_;
  // By slot, [N].
  std::vector<Grain> grains_;
  std::vector<std::array<double, d>> held_;  ///< forces of all else; empty: none
  std::vector<Felt> felt_;                   ///< forces of those of pairs that are computed

  std::vector<std::vector<Pair>> due_;  ///< by step: pairs of slots that are apart, to be looked at then
  std::vector<Pair> near_, meeting_;
  std::vector<double> apart_for_;
  std::vector<int> first_;
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
