#include "src/granular/contact_motion.hpp"

#include <algorithm>
#include <cmath>

#include "src/granular/contacts.hpp"
#include "src/granular/pair_motion.hpp"

namespace lichtenberg::granular {
namespace {

/// A law for the two grains of one contact.
template <class Law>
struct OfPair {
  const Law& law;
  double scale;

  ContactParts operator()(double overlap) const { return law.parts(overlap, scale); }
};

template <int d, class Law>
class Motion final : public ContactMotion {
 public:
  explicit Motion(const Law& law) : law_(law) {}

  ContactRecord advance(Bodies& bodies, std::vector<GrainContact>& contacts, std::span<const Pair> pairs,
                        std::span<const double> held, double time, double dt, int steps,
                        parallel::Team& team) override {
    ContactRecord record{.time = time + dt, .dt = dt};
    held_.assign(held.begin(), held.end());
    held_.resize(bodies.momentum.size());
    largest_held_ = largest_over_mass(bodies, held_);
    // Contacts may speed a grain up: twice the fastest is more than any has after a collision.
    const double speed = 2 * fastest(bodies) + largest_held_ * dt;
    find_near(bodies, pairs, speed, dt);
    for (int n = 0; n < steps; ++n) step(bodies, contacts, speed, time + n * (dt / steps), dt / steps, team, record);
    record.open = contacts;
    return record;
  }

 private:
  static constexpr std::size_t ahead = 16;  ///< pairs

  /// A pair that is in contact or will be within the step.
  struct Active {
    Pair pair;
    const GrainContact* contact = nullptr;  ///< null: not yet in contact
    PairState<d> start;
    Vec<d> force;    ///< of the contact on j, at the start of the step
    Vec<d> halfway;  ///< in the middle of it
    PairStep<d> step;
    Vec<d> impulse;  ///< on j, the integral of the contact's force over the step
    Vec<d> shift;    ///< and the integral of that: what j moves by, times its mass
  };

  OfPair<Law> of(const Bodies& b, Pair p) const { return {law_, law_.scale(b.radius[p.i], b.radius[p.j])}; }
  PairMotion<d, OfPair<Law>> motion(const Bodies& b, Pair p, const Outside<d>& outside) const {
    return {of(b, p), reach(b, p), reduced_mass(b, p), outside};
  }

  void step(Bodies& bodies, std::vector<GrainContact>& contacts, double speed, double time, double dt,
            parallel::Team& team, ContactRecord& record) {
    find_active(bodies, contacts, speed, dt);
    feel_each_other(bodies, dt);
    integrate(bodies, time, dt, team);
    move(bodies, dt);
    note(bodies, time, dt, contacts, record);
  }

  /// Those of the pairs that may touch within dt if no grain is faster than `speed`.
  void find_near(const Bodies& bodies, std::span<const Pair> pairs, double speed, double dt) {
    const Spheres<d> grains = spheres<d>(bodies);
    const NearestImage<d> nearest(grains.box);
    near_.clear();
    near_.resize(pairs.size());
    std::size_t count = 0;
    for (std::size_t p = 0; p < pairs.size(); ++p) {  // no branch: which are near is hard to guess
      // They lie anywhere in memory.
      if (p + ahead < pairs.size()) __builtin_prefetch(&bodies.position[pairs[p + ahead].j * d]);
      near_[count] = pairs[p];
      count += is_within(bodies, nearest, pairs[p], reach(bodies, pairs[p]) + 2 * speed * dt);
    }
    near_.resize(count);
  }
  static bool is_within(const Bodies& bodies, const NearestImage<d>& nearest, Pair pair, double distance) {
    const double *first = &bodies.position[pair.i * d], *second = &bodies.position[pair.j * d];
    double sum = 0;
    for (int k = 0; k < d; ++k) {
      const double apart = nearest(first[k] - second[k], k);
      sum += apart * apart;
    }
    return sum < distance * distance;
  }

  /// Pairs in contact, and those that may come to it, if contacts accelerate them to each other.
  void find_active(const Bodies& bodies, std::span<const GrainContact> contacts, double speed, double dt) {
    const Spheres<d> grains = spheres<d>(bodies);
    const NearestImage<d> nearest(grains.box);
    active_.clear();
    auto contact = contacts.begin();
    const double slack = (largest_acceleration(bodies, contacts) + largest_held_) * dt * dt;
    const double path = 2 * speed * dt + slack;
    for (const Pair pair : near_) {
      if (!is_within(bodies, nearest, pair, reach(bodies, pair) + path)) continue;
      while (contact != contacts.end() && contact->pair < pair) ++contact;
      const bool touching = contact != contacts.end() && contact->pair == pair;
      const PairState<d> state = seen(bodies, grains, pair);
      if (!touching && !may_touch(state, reach(bodies, pair) + slack, dt)) continue;
      active_.push_back({.pair = pair, .contact = touching ? &*contact : nullptr, .start = state});
    }
  }

  /// What a grain could feel if all contacts that it may have pushed like the one that pushes most.
  double largest_acceleration(const Bodies& bodies, std::span<const GrainContact> contacts) const {
    const Spheres<d> grains = spheres<d>(bodies);
    double largest = 0;
    for (const GrainContact& contact : contacts) {
      const auto [i, j] = contact.pair;
      const double push = norm(force(bodies, contact.pair, seen(bodies, grains, contact.pair)));
      largest = std::max(largest, push / std::min(bodies.mass[i], bodies.mass[j]));
    }
    return 2 * largest;
  }

  /// Whether two in straight flight come closer than `distance` within dt.
  static bool may_touch(const PairState<d>& s, double distance, double dt) {
    const double approach = -dot(s.apart, s.velocity), v2 = norm2(s.velocity);
    const double t = approach <= 0 ? 0 : approach < v2 * dt ? approach / v2 : dt;
    return norm2(s.apart + t * s.velocity) < distance * distance;
  }

  /// The forces of contacts at the start and in the middle of the step, so that each knows what the others of its
  /// grains do. In the middle grains are where the forces at the start carry them.
  void feel_each_other(const Bodies& bodies, double dt) {
    start_.resize(held_.size());
    halfway_.resize(held_.size());
    for (const Active& a : active_)
      for (const int i : {a.pair.i, a.pair.j}) {
        std::copy_n(&held_[i * d], d, &start_[i * d]);
        std::copy_n(&held_[i * d], d, &halfway_[i * d]);
      }
    for (Active& a : active_) {
      a.force = a.contact ? force(bodies, a.pair, a.start) : Vec<d>{};
      add(start_, a, a.force);
    }
    const double h = 0.5 * dt;
    for (Active& a : active_) {
      const Vec<d> acceleration = relative(start_, bodies, a.pair);
      a.halfway = force(
          bodies, a.pair,
          {a.start.apart + h * a.start.velocity + (0.5 * h * h) * acceleration, a.start.velocity + h * acceleration});
      add(halfway_, a, a.halfway);
    }
  }

  Vec<d> force(const Bodies& bodies, Pair pair, const PairState<d>& state) const {
    return (motion(bodies, pair, {}).force(state) / norm(state.apart)) * state.apart;
  }
  static void add(std::vector<double>& sums, const Active& a, Vec<d> push) {
    for (int k = 0; k < d; ++k) sums[a.pair.i * d + k] -= push[k], sums[a.pair.j * d + k] += push[k];
  }
  static Vec<d> relative(const std::vector<double>& force, const Bodies& b, Pair p) {
    return vector_of<d>(force, p.j) / b.mass[p.j] - vector_of<d>(force, p.i) / b.mass[p.i];
  }

  void integrate(const Bodies& bodies, double time, double dt, parallel::Team& team) {
    constexpr int pairs_a_task = 64;
    const int n = static_cast<int>(active_.size());
    team.for_each((n + pairs_a_task - 1) / pairs_a_task, [&](int task) {
      for (int k = task * pairs_a_task; k < std::min(n, (task + 1) * pairs_a_task); ++k)
        integrate(bodies, active_[k], time, dt);
    });
  }

  void integrate(const Bodies& bodies, Active& a, double time, double dt) const {
    const double mass = reduced_mass(bodies, a.pair);
    const Vec<d> first = relative(start_, bodies, a.pair) - a.force / mass;
    const Vec<d> middle = relative(halfway_, bodies, a.pair) - a.halfway / mass;
    const Outside<d> outside{first, (2 / dt) * (middle - first)};
    const auto pair = motion(bodies, a.pair, outside);
    // One that touched at the end of the step before may, by rounding, have done so later than now.
    a.step = a.contact ? pair.in_contact(a.start, std::max(time - a.contact->since, 0.0), dt)
                       : pair.approaching(a.start, dt);
    if (!a.contact && a.step.touched < 0) return;  // no impulse, not even one of rounding
    a.impulse = mass * (a.step.end.velocity - a.start.velocity - outside.velocity(dt));
    a.shift = mass * (a.step.end.apart - a.start.apart - dt * a.start.velocity - outside.path(dt));
  }

  void move(Bodies& bodies, double dt) const {
    double *position = bodies.position.data(), *momentum = bodies.momentum.data();
    const double *held = held_.data(), *mass = bodies.mass.data();
    for (int i = 0; i < bodies.size(); ++i) {
      const double flight = dt / mass[i];
      for (int k = i * d; k < (i + 1) * d; ++k) {
        position[k] += flight * (momentum[k] + 0.5 * dt * held[k]);
        momentum[k] += dt * held[k];
      }
    }
    for (const Active& a : active_)
      for (int k = 0; k < d; ++k) {
        bodies.position[a.pair.i * d + k] -= a.shift[k] / bodies.mass[a.pair.i];
        bodies.position[a.pair.j * d + k] += a.shift[k] / bodies.mass[a.pair.j];
        bodies.momentum[a.pair.i * d + k] -= a.impulse[k];
        bodies.momentum[a.pair.j * d + k] += a.impulse[k];
      }
  }

  /// Which contacts there are now, and what became of the others.
  void note(const Bodies& bodies, double time, double dt, std::vector<GrainContact>& contacts, ContactRecord& record) {
    const Spheres<d> grains = spheres<d>(bodies);
    std::vector<Touch> touches;
    touches.reserve(active_.size());
    for (const Active& a : active_) {
      record.dissipated += a.step.dissipated;
      if (!a.contact && a.step.touched < 0) continue;
      const bool open = norm(apart(grains, a.pair)) < reach(bodies, a.pair);
      if (a.contact)
        touches.push_back({*a.contact, false, open});
      else
        touches.push_back({{a.pair, time + a.step.touched, a.step.impact_speed}, true, open});
    }
    granular::note(std::move(touches), bodies, time + dt, contacts, record);
  }

  Law law_;
  std::vector<Pair> near_;
  std::vector<Active> active_;
  std::vector<double> held_;             ///< forces of all else on the grains, [N * d]
  double largest_held_ = 0;              ///< acceleration
  std::vector<double> start_, halfway_;  ///< all forces on the grains, [N * d], of those of active pairs
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
