#include "src/granular/contact_motion.hpp"

#include <algorithm>
#include <cmath>
#include <experimental/simd>

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

/// A number of each pair.
class Column {
 public:
  void resize(std::size_t pairs) { values_.resize(pairs); }
  double& operator[](int pair) { return values_[pair]; }
  double operator[](int pair) const { return values_[pair]; }

  Several at(Row row) const { return Several(&values_[row.first], anywhere); }
  Several at(const Picked& of) const {
    return Several([&](int lane) { return values_[of[lane]]; });
  }
  void put(Row row, const Several& x) { x.copy_to(&values_[row.first], anywhere); }
  void put(const Picked& of, const Several& x) {
    for (int lane = 0; lane < width; ++lane) values_[of[lane]] = x[lane];
  }

 private:
  std::vector<double> values_;
};

template <int d>
using Vectors = LaneVec<d, Several>;

template <int d>
class VectorColumn {
 public:
  void resize(std::size_t pairs) {
    for (Column& column : of_) column.resize(pairs);
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
  std::array<Column, d> of_;
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

template <int d, class Law>
class Motion final : public ContactMotion {
 public:
  explicit Motion(const Law& law) : law_(law) {}

  ContactsFollowed advance(Bodies& bodies, std::vector<GrainContact>& contacts, std::span<const Pair> pairs,
                           std::span<const double> held, double time, double dt, int steps,
                           parallel::Team& team) override {
    ContactsFollowed followed{.record = {.time = time + dt, .dt = dt}};
    held_.assign(held.begin(), held.end());
    held_.resize(bodies.momentum.size());
    felt_.resize(bodies.size());
    largest_held_ = largest_over_mass(bodies, held_);
    steps_ = steps;
    dt_ = dt / steps;
    // Contacts may speed a grain up: twice the fastest is more than any has after a collision.
    speed_ = 2 * fastest(bodies) + largest_held_ * dt;
    count_touches(bodies, contacts);
    find_near(bodies, contacts, pairs);
    for (int n = 0; n < steps; ++n) {
      look(bodies, contacts, time + n * dt_, n == 0, team);
      if (n == 0)
        followed.stored_at_start = total(stored_, touching_);
      else
        note(contacts, time + n * dt_, followed.record);
      step(bodies, contacts, n, time + n * dt_, team, followed.record);
    }
    look(bodies, contacts, time + dt, false, team);
    followed.stored_at_end = total(stored_, touching_);
    note(contacts, time + dt, followed.record);
    int p = 0;
    std::erase_if(contacts, [&](const GrainContact&) { return !(age_[p++] >= 0); });
    followed.record.open = contacts;
    return followed;
  }

 private:
  static constexpr std::size_t ahead = 16;  ///< pairs
  static constexpr int pairs_a_task = 512;  ///< a multiple of any width
  using Pairs = PairMotion<d, OfPairs<Law>, Several>;
  /// All forces on a grain, at the start and in the middle of a step; in one line of a cache.
  struct alignas(64) Felt {
    std::array<double, d> start, halfway;
  };

  /// Pairs in the order of the contacts, then those that may come to it.
  void resize(std::size_t pairs) {
    pair_.resize(pairs);
    const std::size_t whole = (pairs + width - 1) / width * width;
    pair_.resize(whole, pairs > 0 ? pair_[pairs - 1] : Pair{});
    for (auto* column : {&reach_, &mass_, &scale_, &lower_, &higher_, &age_, &overlap_, &stored_, &push_, &dissipated_,
                         &touched_, &impact_speed_})
      column->resize(whole);
    for (auto* column : {&apart_, &velocity_, &force_, &outside_, &halfway_force_, &impulse_, &shift_})
      column->resize(whole);
  }

  /// Calls visit(row) for those from `first` on, a multiple of the width.
  template <class Visit>
  void for_each_row(int first, int last, parallel::Team& team, const Visit& visit) {
    team.for_each((last - first + pairs_a_task - 1) / pairs_a_task, [&](int task) {
      const int begin = first + task * pairs_a_task;
      for (int p = begin; p < std::min(last, begin + pairs_a_task); p += width) visit(Row{p});
    });
  }

  void count_touches(const Bodies& bodies, std::span<const GrainContact> contacts) {
    touches_.assign(bodies.size(), 0);
    for (const GrainContact& contact : contacts) ++touches_[contact.pair.i], ++touches_[contact.pair.j];
  }

  /// Those of the pairs that may touch, sorted by the first step in which they may, if no grain is faster than
  /// `speed_`; contacts excepted.
  void find_near(const Bodies& bodies, std::span<const GrainContact> contacts, std::span<const Pair> pairs) {
    const NearestImage<d> nearest(spheres<d>(bodies).box);
    near_.resize(pairs.size() + width);
    int count = 0;
    std::size_t p = 0;
    for (; p + width <= pairs.size(); p += width) {
      // They lie anywhere in memory.
      if (p + ahead + width <= pairs.size())
        for (std::size_t q = p + ahead; q < p + ahead + width; ++q)
          __builtin_prefetch(&bodies.position[pairs[q].j * d]);
      count += put_near(bodies, nearest, &pairs[p], &near_[count]);
    }
    for (; p < pairs.size(); ++p) {
      const double most = reach(bodies, pairs[p]) + farthest_approach();
      if (norm2(apart(bodies, nearest, pairs[p])) < most * most) near_[count++] = pairs[p];
    }
    due_.resize(steps_);
    for (auto& pairs_due : due_) pairs_due.clear();
    auto contact = contacts.begin();
    for (int n = 0; n < count; ++n) {
      while (contact != contacts.end() && contact->pair < near_[n]) ++contact;
      if (contact != contacts.end() && contact->pair == near_[n]) continue;
      wait(near_[n], 0, steps_ == 1 ? 0 : norm(apart(bodies, nearest, near_[n])) - reach(bodies, near_[n]));
    }
  }
  double farthest_approach() const { return 2 * speed_ * dt_ * steps_; }
  /// Copies those of a row that are near, without branches: which ones is hard to guess. Returns how many.
  [[gnu::flatten]] int put_near(const Bodies& bodies, const NearestImage<d>& nearest, const Pair* row, Pair* to) const {
    const Several most = of(bodies.radius, [&](int lane) { return row[lane].i; }) +
                         of(bodies.radius, [&](int lane) { return row[lane].j; }) + farthest_approach();
    Several distance2 = 0;
    for (int k = 0; k < d; ++k) {
      const Several r = nearest_image(nearest,
                                      of(bodies.position, [&](int lane) { return row[lane].j * d + k; }) -
                                          of(bodies.position, [&](int lane) { return row[lane].i * d + k; }),
                                      k);
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
  template <class Index>
  static Several of(const std::vector<double>& values, const Index& index) {
    return Several([&](int lane) { return values[index(lane)]; });
  }
  static Several nearest_image(const NearestImage<d>& nearest, const Several& x, int k) {
    return x - nearest.length[k] * nearbyint(x * nearest.turns_a_metre[k]);
  }
  static Vec<d> apart(const Bodies& bodies, const NearestImage<d>& nearest, Pair pair) {
    Vec<d> r;
    for (int k = 0; k < d; ++k) r[k] = nearest(bodies.position[pair.j * d + k] - bodies.position[pair.i * d + k], k);
    return r;
  }
  /// Two whose surfaces are that far apart at the beginning of step n are looked at again when they may touch.
  void wait(Pair pair, int n, double gap) {
    const double steps = gap / (2 * speed_ * dt_), then = steps >= 1 ? n + steps : n;
    if (then < steps_) due_[static_cast<int>(then)].push_back(pair);
  }

  /// Where the pairs in contact are, and the force on each: zero on those that have parted.
  void look(const Bodies& bodies, std::span<const GrainContact> contacts, double time, bool all_touch,
            parallel::Team& team) {
    touching_ = static_cast<int>(contacts.size());
    pair_.clear();
    for (const GrainContact& contact : contacts) pair_.push_back(contact.pair);
    resize(touching_);
    for_each_row(0, touching_, team, [&](Row row) {
      see(bodies, row);
      const Several since([&](int lane) { return contacts[std::min(row[lane], touching_ - 1)].since; });
      // One that touched at the end of the step before may, by rounding, have done so later than now.
      const Several age = not_below<Several>(time - since, 0);
      age_.put(row, all_touch ? age : chosen<Several>(overlap_.at(row) > 0, age, -1));
      push(row);
    });
  }
  [[gnu::flatten]] void see(const Bodies& bodies, Row row) {
    const NearestImage<d> nearest(spheres<d>(bodies).box);
    const auto lower_of = [&](const std::vector<double>& values, int size, int k) {
      return of(values, [&](int lane) { return pair_[row[lane]].i * size + k; });
    };
    const auto higher_of = [&](const std::vector<double>& values, int size, int k) {
      return of(values, [&](int lane) { return pair_[row[lane]].j * size + k; });
    };
    const Several radius_i = lower_of(bodies.radius, 1, 0), radius_j = higher_of(bodies.radius, 1, 0);
    const Several lower = 1.0 / lower_of(bodies.mass, 1, 0), higher = 1.0 / higher_of(bodies.mass, 1, 0);
    Vectors<d> r, v;
    for (int k = 0; k < d; ++k) {
      r[k] = nearest_image(nearest, higher_of(bodies.position, d, k) - lower_of(bodies.position, d, k), k);
      v[k] = higher_of(bodies.momentum, d, k) * higher - lower_of(bodies.momentum, d, k) * lower;
    }
    apart_.put(row, r);
    velocity_.put(row, v);
    lower_.put(row, lower);
    higher_.put(row, higher);
    reach_.put(row, radius_i + radius_j);
    mass_.put(row, 1.0 / (lower + higher));
    scale_.put(row, law_.scale(radius_i, radius_j));
    overlap_.put(row, radius_i + radius_j - sqrt(norm2(r)));
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
    push_.put(row, sqrt(norm2(force)) * not_below<Several>(lower_.at(row), higher_.at(row)));
    stored_.put(row, law_.push(not_below<Several>(overlap_.at(row), 0), scale_.at(row)).stored);
  }

  /// Writes down what became of contacts until `time`.
  void note(std::span<const GrainContact> contacts, double time, ContactRecord& record) {
    for (int p = 0; p < touching_; ++p) {
      const GrainContact& contact = contacts[p];
      const double overlap = overlap_[p], sum = reach_[p];
      record.largest_overlap = std::max(record.largest_overlap, overlap / sum);
      const PairState<d> now{apart_[p], velocity_[p]};
      // What is still to be stored if they are to stop here, over what is.
      if (sum - overlap < too_close * sum)
        refuse_flight_through(contact, 1 + mass_[p] * closing(now) * closing(now) / 2 / stored_[p]);
      if (overlap > 0) continue;
      record.ended.push_back({contact, -closing(now), time, speed_across(now)});
      --touches_[contact.pair.i], --touches_[contact.pair.j];
    }
  }

  void step(Bodies& bodies, std::vector<GrainContact>& contacts, int n, double time, parallel::Team& team,
            ContactRecord& record) {
    add_candidates(bodies, n, team);
    feel_each_other(team);
    integrate(team);
    move(bodies);
    record.dissipated += total(dissipated_, count_);
    begin_contacts(contacts, n, time, record);
  }

  /// Pairs that are apart and may come into contact, if contacts accelerate them to each other.
  void add_candidates(const Bodies& bodies, int n, parallel::Team& team) {
    double largest = 0;  // what a grain could feel if all its contacts pushed like the one that pushes most
    for (int p = 0; p < touching_; ++p) largest = std::max(largest, push_[p]);
    const double slack = (2 * largest + largest_held_) * dt_ * dt_, path = 2 * speed_ * dt_ + slack;
    const NearestImage<d> nearest(spheres<d>(bodies).box);
    pair_.resize(touching_);
    for (const Pair pair : due_[n]) {
      const Vec<d> r = apart(bodies, nearest, pair);
      const double sum = reach(bodies, pair), most = sum + path, distance2 = norm2(r);
      if (distance2 >= most * most) {
        wait(pair, n + 1, std::sqrt(distance2) - most);
        continue;
      }
      const Vec<d> v = vector_of<d>(bodies.momentum, pair.j) / bodies.mass[pair.j] -
                       vector_of<d>(bodies.momentum, pair.i) / bodies.mass[pair.i];
      if (may_touch({r, v}, sum + slack))
        pair_.push_back(pair);
      else
        wait(pair, n + 1, 0);
    }
    count_ = static_cast<int>(pair_.size());
    resize(count_);
    for (int p = touching_; p < static_cast<int>(pair_.size()); ++p) age_[p] = -1;
    for_each_row(touching_ / width * width, count_, team, [&](Row row) {
      see(bodies, row);
      push(row);
    });
  }

  /// Whether two in straight flight come closer than `distance` within the step.
  bool may_touch(const PairState<d>& s, double distance) const {
    const double approach = -dot(s.apart, s.velocity), v2 = norm2(s.velocity);
    const double t = approach <= 0 ? 0 : approach < v2 * dt_ ? approach / v2 : dt_;
    return norm2(s.apart + t * s.velocity) < distance * distance;
  }

  /// The forces of contacts at the start and in the middle of the step, so that each knows what the others of its
  /// grains do. In the middle grains are where the forces at the start carry them.
  void feel_each_other(parallel::Team& team) {
    for (int p = 0; p < count_; ++p)
      for (const int i : {pair_[p].i, pair_[p].j})
        for (int k = 0; k < d; ++k) felt_[i].start[k] = felt_[i].halfway[k] = held_[i * d + k];
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

  void move(Bodies& bodies) const {
    fly(bodies);
    double *position = bodies.position.data(), *momentum = bodies.momentum.data();
    for (int p = 0; p < count_; ++p) {
      const auto [i, j] = pair_[p];
      const Vec<d> shift = shift_[p], impulse = impulse_[p];
      for (int k = 0; k < d; ++k) {
        position[i * d + k] -= lower_[p] * shift[k];
        position[j * d + k] += higher_[p] * shift[k];
        momentum[i * d + k] -= impulse[k];
        momentum[j * d + k] += impulse[k];
      }
    }
  }

  /// Without contacts.
  [[gnu::flatten]] void fly(Bodies& bodies) const {
    double *position = bodies.position.data(), *momentum = bodies.momentum.data();
    const int components = static_cast<int>(held_.size());
    int k = 0;
    for (; k + width <= components; k += width) {
      const Several flight = dt_ / of(bodies.mass, [&](int lane) { return (k + lane) / d; });
      const Several p(&momentum[k], anywhere), force(&held_[k], anywhere);
      (Several(&position[k], anywhere) + flight * (p + 0.5 * dt_ * force)).copy_to(&position[k], anywhere);
      (p + dt_ * force).copy_to(&momentum[k], anywhere);
    }
    for (; k < components; ++k) {
      position[k] += dt_ / bodies.mass[k / d] * (momentum[k] + 0.5 * dt_ * held_[k]);
      momentum[k] += dt_ * held_[k];
    }
  }

  /// Which contacts there are after step n: those that are open and those that have begun.
  void begin_contacts(std::vector<GrainContact>& contacts, int n, double time, ContactRecord& record) {
    begun_.clear();
    for (int p = 0; p < count_; ++p) {
      if (age_[p] >= 0) continue;
      if (touched_[p] >= 0)
        begun_.push_back({pair_[p], time + touched_[p], impact_speed_[p]});
      else
        wait(pair_[p], n + 1, 0);
    }
    int p = 0;
    std::erase_if(contacts, [&](const GrainContact&) { return !(age_[p++] >= 0); });
    if (begun_.empty()) return;
    std::ranges::sort(begun_, {}, &GrainContact::pair);
    for (const GrainContact& contact : begun_) ++touches_[contact.pair.i], ++touches_[contact.pair.j];
    const auto alone = [&](Pair pair) { return touches_[pair.i] == 1 && touches_[pair.j] == 1; };
    for (GrainContact& contact : begun_) contact.alone = alone(contact.pair);
    for (GrainContact& contact : contacts) contact.alone = contact.alone && alone(contact.pair);
    open_.resize(contacts.size() + begun_.size());
    std::ranges::merge(contacts, begun_, open_.begin(), {}, &GrainContact::pair, &GrainContact::pair);
    contacts.swap(open_);
    record.begun.insert(record.begun.end(), begun_.begin(), begun_.end());
  }

  Law law_;
  double dt_ = 0, speed_ = 0, largest_held_ = 0;
  int steps_ = 0, touching_ = 0, count_ = 0;
  std::vector<Pair> near_;
  std::vector<std::vector<Pair>> due_;  ///< by step: apart, to be looked at then
  std::vector<int> touches_;            ///< of a grain, [N]
  std::vector<double> held_;            ///< forces of all else on the grains, [N * d]
  std::vector<Felt> felt_;              ///< by grains, [N], of those of pairs that are computed
  std::vector<GrainContact> begun_, open_;

  // Of the pairs that are computed in a step: those in contact in ascending order, then those that may come to it.
  std::vector<Pair> pair_;
  Column reach_, mass_, scale_, lower_, higher_;  ///< mass: reduced; lower, higher: 1 / mass of the two
  Column age_, overlap_, stored_, push_;          ///< age below 0: they do not touch
  VectorColumn<d> apart_, velocity_, force_;      ///< force: on the higher, at the start of the step
  VectorColumn<d> outside_, halfway_force_;       ///< outside: acceleration by others, at the start
  VectorColumn<d> impulse_, shift_;               ///< on the higher; shift: what it moves by, times its mass
  Column dissipated_, touched_, impact_speed_;
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
