#include "src/granular/contact_motion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "solvers/error.hpp"
#include "src/granular/pair_motion.hpp"
#include "src/model/neighbours.hpp"

namespace lichtenberg::granular {
namespace {

/// A law for the two grains of one contact.
template <class Law>
struct OfPair {
  const Law& law;
  double scale;

  effects::ContactParts operator()(double overlap) const { return law.parts(overlap, scale); }
};

template <int d>
Vec<d> vector_of(std::span<const double> values, int i) {
  Vec<d> v;
  for (int k = 0; k < d; ++k) v[k] = values[i * d + k];
  return v;
}

template <int d, class Law>
class Motion final : public ContactMotion {
 public:
  explicit Motion(const Law& law) : law_(law) {}

  ContactRecord advance(Bodies& bodies, std::span<const Pair> pairs, double time, double dt, int steps,
                        parallel::Team& team) override {
    ContactRecord record{.time = time + dt, .dt = dt};
    for (int n = 0; n < steps; ++n) step(bodies, pairs, time + n * (dt / steps), dt / steps, team, record);
    record.open = contacts_;
    return record;
  }

  double stored_energy(const Bodies& bodies) const override {
    const Spheres<d> grains = spheres<d>(bodies);
    double energy = 0;
    for (const GrainContact& contact : contacts_) {
      const double overlap = reach(bodies, contact.pair) - norm(apart(grains, contact.pair));
      if (overlap > 0) energy += of(bodies, contact.pair)(overlap).stored;
    }
    return energy;
  }

 private:
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

  static double reach(const Bodies& b, Pair p) { return b.radius[p.i] + b.radius[p.j]; }
  static Vec<d> apart(const Spheres<d>& grains, Pair p) {
    return grains.box.difference(grains.place(p.j), grains.place(p.i));
  }
  static double reduced_mass(const Bodies& b, Pair p) {
    return b.mass[p.i] * b.mass[p.j] / (b.mass[p.i] + b.mass[p.j]);
  }
  OfPair<Law> of(const Bodies& b, Pair p) const { return {law_, law_.scale(b.radius[p.i], b.radius[p.j])}; }
  PairMotion<d, OfPair<Law>> motion(const Bodies& b, Pair p, const Outside<d>& outside) const {
    return {of(b, p), reach(b, p), reduced_mass(b, p), outside};
  }

  static PairState<d> seen(const Bodies& bodies, const Spheres<d>& grains, Pair p) {
    return {apart(grains, p), vector_of<d>(bodies.momentum, p.j) / bodies.mass[p.j] -
                                  vector_of<d>(bodies.momentum, p.i) / bodies.mass[p.i]};
  }

  void step(Bodies& bodies, std::span<const Pair> pairs, double time, double dt, parallel::Team& team,
            ContactRecord& record) {
    find_active(bodies, pairs, dt);
    feel_each_other(bodies, dt);
    integrate(bodies, time, dt, team);
    move(bodies, dt);
    note(bodies, time, dt, record);
  }

  /// Pairs in contact, and those that may come to it, if contacts accelerate them to each other.
  void find_active(const Bodies& bodies, std::span<const Pair> pairs, double dt) {
    const Spheres<d> grains = spheres<d>(bodies);
    active_.clear();
    auto contact = contacts_.begin();
    const double slack = largest_acceleration(bodies) * dt * dt;
    for (const Pair pair : pairs) {
      while (contact != contacts_.end() && contact->pair < pair) ++contact;
      const bool touching = contact != contacts_.end() && contact->pair == pair;
      const PairState<d> state = seen(bodies, grains, pair);
      if (!touching && !may_touch(state, reach(bodies, pair) + slack, dt)) continue;
      active_.push_back({.pair = pair, .contact = touching ? &*contact : nullptr, .start = state});
    }
  }

  /// What a grain could feel if all contacts that it may have pushed like the one that pushes most.
  double largest_acceleration(const Bodies& bodies) {
    const Spheres<d> grains = spheres<d>(bodies);
    double largest = 0;
    for (const GrainContact& contact : contacts_) {
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
    start_.assign(bodies.size() * d, 0);
    halfway_.assign(bodies.size() * d, 0);
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
    a.step = a.contact ? pair.in_contact(a.start, time - a.contact->since, dt) : pair.approaching(a.start, dt);
    if (!a.contact && a.step.touched < 0) return;  // no impulse, not even one of rounding
    a.impulse = mass * (a.step.end.velocity - a.start.velocity - outside.velocity(dt));
    a.shift = mass * (a.step.end.apart - a.start.apart - dt * a.start.velocity - outside.path(dt));
  }

  void move(Bodies& bodies, double dt) const {
    for (int i = 0; i < bodies.size(); ++i)
      for (int k = i * d; k < (i + 1) * d; ++k) bodies.position[k] += dt / bodies.mass[i] * bodies.momentum[k];
    for (const Active& a : active_)
      for (int k = 0; k < d; ++k) {
        bodies.position[a.pair.i * d + k] -= a.shift[k] / bodies.mass[a.pair.i];
        bodies.position[a.pair.j * d + k] += a.shift[k] / bodies.mass[a.pair.j];
        bodies.momentum[a.pair.i * d + k] -= a.impulse[k];
        bodies.momentum[a.pair.j * d + k] += a.impulse[k];
      }
  }

  /// Which contacts there are now, and what became of the others.
  void note(const Bodies& bodies, double time, double dt, ContactRecord& record) {
    const Spheres<d> grains = spheres<d>(bodies);
    std::vector<GrainContact> now;
    now.reserve(active_.size());
    touching_.assign(bodies.size(), 0);
    for (const Active& a : active_)
      if (a.contact || a.step.touched >= 0) ++touching_[a.pair.i], ++touching_[a.pair.j];
    for (const Active& a : active_) {
      record.dissipated += a.step.dissipated;
      if (!a.contact && a.step.touched < 0) continue;
      GrainContact contact = a.contact ? *a.contact : GrainContact{a.pair, time + a.step.touched, a.step.impact_speed};
      if (touching_[a.pair.i] > 1 || touching_[a.pair.j] > 1) contact.alone = false;
      if (!a.contact) record.begun.push_back(contact);
      const PairState<d> state = seen(bodies, grains, a.pair);
      const double distance = norm(state.apart), overlap = reach(bodies, a.pair) - distance;
      record.largest_overlap = std::max(record.largest_overlap, overlap / reach(bodies, a.pair));
      if (distance < too_close * reach(bodies, a.pair)) refuse(a.pair, contact);
      if (overlap > 0)
        now.push_back(contact);
      else
        record.ended.push_back(ended(contact, state, time + dt));
    }
    contacts_ = std::move(now);
  }

  static Collision ended(const GrainContact& contact, const PairState<d>& state, double time) {
    const Vec<d> n = state.apart / norm(state.apart);
    const double along = dot(n, state.velocity);
    return {contact, along, time, norm(state.velocity - along * n)};
  }

  /// Of the sum of radii. Where centres pass through each other, a contact has no direction.
  static constexpr double too_close = 0.1;

  [[noreturn]] static void refuse(Pair pair, const GrainContact& contact) {
    throw Failure(fmt::format(
        "grains {} and {} fly through each other after an impact at speed {:.3g}: the contact is too soft for it; a "
        "larger stiffness, of a stage its stage.stiffness, or a lower temperature is needed",
        pair.i, pair.j, contact.impact_speed));
  }

  Law law_;
  std::vector<Active> active_;
  std::vector<double> start_, halfway_;  ///< forces of contacts on the grains, [N * d]
  std::vector<int> touching_;            ///< [N]
  double slack_ = 0;                     ///< an acceleration that no pair exceeded in the last step
};

}  // namespace

std::unique_ptr<ContactMotion> make_contact_motion(const effects::GrainContactLaw& law, int dimension) {
  return std::visit(
      [&](const auto& one) -> std::unique_ptr<ContactMotion> {
        using Law = std::decay_t<decltype(one)>;
        if (dimension == 3) return std::make_unique<Motion<3, Law>>(one);
        return std::make_unique<Motion<2, Law>>(one);
      },
      law);
}

}  // namespace lichtenberg::granular
