#pragma once

// The steps of contacts (../contact_motion.cpp) on an executor. Pairs that may matter within an outer step are listed,
// each once, and each is computed by itself; a grain adds up what its own pairs do to it, in ascending order of its
// partners, as the CPU does. The order of the list does not matter.

#include <array>
#include <cmath>
#include <cstdint>

#include "solvers/geometry/box.hpp"
#include "solvers/neighbours/table.hpp"
#include "src/effects/charge_exchange_law.hpp"
#include "src/granular/pair_motion.hpp"

namespace lichtenberg::granular::device {

/// Grains as they are sorted.
struct GrainsView {
  int count = 0;
  Vec3 *place = nullptr, *momentum = nullptr;
  const double *mass = nullptr, *radius = nullptr;
  const int* number = nullptr;           ///< by which the scene knows it
  const Vec3* held = nullptr;            ///< forces of charges
  int* busy = nullptr;                   ///< 1: some pair of its is active
  int* touches = nullptr;                ///< contacts of the last step
  std::int64_t* collisions = nullptr;    ///< that have begun, while charge was exchanged
  std::int64_t* moved_charge = nullptr;  ///< quanta, that are still to be added to its charge
  std::int64_t* dissipated = nullptr;    ///< quanta of energy
};

/// A pair that may matter within an outer step.
struct NearPair {
  int lower = 0, higher = 0;  ///< where the two are sorted: that of the lower number first
  int entry = 0;              ///< of the table, in the lower's row: what is known of a contact stands there
  int state = 0;              ///< PairStates of a step
};
enum PairStates { idle, moving, pushed, touched };  ///< looked at; in contact; and this since this step

struct ContactsView {
  TableView table;
  const int* owner = nullptr;  ///< of an entry: whose row it is in
  int* near = nullptr;         ///< which entries may matter within an outer step
  int* count = nullptr;        ///< how many of a grain's, [N]
  int* pair_of = nullptr;  ///< the k-th of grain s at begin(s) + k, by partner's number: its pair, ~ if s is the higher
  double *since = nullptr, *impact_speed = nullptr;  ///< of an entry; no number of 0 or more: no contact
  int* alone = nullptr;

  NearPair* pair = nullptr;
  int* active = nullptr;                                        ///< pairs that are computed in a step
  Vec3 *force = nullptr, *halfway = nullptr, *first = nullptr;  ///< of a pair: on the higher; without it, relative
  Vec3 *impulse = nullptr, *shift = nullptr;
  double* dissipated = nullptr;
};

/// What steps find, for the host.
struct Found {
  std::int64_t begun = 0, transfers = 0;
  double largest_overlap = 0;  ///< over the sum of radii
  double speed2 = 0;           ///< of the fastest grain
  double acceleration2 = 0;    ///< by charges
  double impact2 = 0;          ///< the square of the largest speed that a contact may still give to its two
  double moved2 = 0;           ///< of the grain that has moved most since grains were sorted
  double push = 0;             ///< largest acceleration by a contact, at the start of a step of contacts
  int passed = 0;              ///< 1 + number of a grain through which another flew
  int lost = 0;                ///< grains whose places are no numbers
  int pairs = 0, active = 0;   ///< in lists
};

struct StepParameters {
  double begin = 0;  ///< time at the start of the outer step
  double outer = 0;  ///< its length
  double inner = 0;  ///< that of a step of contacts
  double reach = 0;  ///< which pairs may matter within an outer step: gap between surfaces
  double held = 0;   ///< largest acceleration by charges
  double charge_quantum = 0;
};

template <class Law>
struct LawOfPair {
  Law law;
  double scale;
  LICHTENBERG_HOST_DEVICE ContactPush<double> operator()(double overlap) const { return law.push(overlap, scale); }
};

template <class Law>
struct ContactSteps {
  using Motion = PairMotion<3, LawOfPair<Law>>;
  static constexpr double too_close = 0.1;  ///< of the sum of radii: centres that pass each other are no contact

  GrainsView grains;
  ContactsView contacts;
  Law law;
  NearestImage<3> nearest;
  const StepParameters* parameters;
  Found* found;
  effects::ImpactExchange exchange;
  std::uint64_t seed = 0;
  bool exchanges = false;
  double energy_quantum = 1;

  LICHTENBERG_HOST_DEVICE double reach(const NearPair& p) const {
    return grains.radius[p.lower] + grains.radius[p.higher];
  }
  LICHTENBERG_HOST_DEVICE double mass(const NearPair& p) const {
    return grains.mass[p.lower] * grains.mass[p.higher] / (grains.mass[p.lower] + grains.mass[p.higher]);
  }
  LICHTENBERG_HOST_DEVICE Vec3 apart(const NearPair& p) const {
    Vec3 r = grains.place[p.higher] - grains.place[p.lower];
    for (int k = 0; k < 3; ++k) r[k] = nearest(r[k], k);
    return r;
  }
  LICHTENBERG_HOST_DEVICE PairState<3> state(const NearPair& p) const {
    return {apart(p),
            grains.momentum[p.higher] / grains.mass[p.higher] - grains.momentum[p.lower] / grains.mass[p.lower]};
  }
  LICHTENBERG_HOST_DEVICE Motion motion(const NearPair& p, const Outside<3>& outside) const {
    const double scale = law.scale(grains.radius[p.lower], grains.radius[p.higher]);
    return {{law, scale}, reach(p), mass(p), outside};
  }
  LICHTENBERG_HOST_DEVICE Vec3 force(const NearPair& p, const PairState<3>& at) const {
    return motion(p, {}).force(at);
  }
  /// Marks entries that may matter within an outer step.
  LICHTENBERG_HOST_DEVICE void mark_near(int e) const {
    const NearPair p{contacts.owner[e], contacts.table.partner[e]};
    const double most = reach(p) + parameters->reach;
    contacts.near[e] = norm2(apart(p)) < most * most;
  }
  /// The marked entries of a grain, in ascending order of its partners' numbers.
  LICHTENBERG_HOST_DEVICE void list_near(int s) const {
    const int begin = contacts.table.begin(s), end = contacts.table.end(s);
    const int* partner = contacts.table.partner;
    int count = 0;
    for (int e = begin; e < end; ++e) {
      if (!contacts.near[e]) continue;
      int to = begin + count++;
      for (; to > begin && grains.number[partner[contacts.near[to - 1]]] > grains.number[partner[e]]; --to)
        contacts.near[to] = contacts.near[to - 1];
      contacts.near[to] = e;
    }
    contacts.count[s] = count;
    grains.touches[s] = grains.busy[s] = 0;
  }
  /// Lists a grain's pairs with higher numbers, and tells both who they are.
  LICHTENBERG_HOST_DEVICE void list_pairs(int s) const {
    const int begin = contacts.table.begin(s), count = contacts.count[s];
    for (int k = 0; k < count; ++k) {
      const int e = contacts.near[begin + k], j = contacts.table.partner[e];
      if (grains.number[s] > grains.number[j]) continue;
      const int place = parallel::take_place(&found->pairs);
      contacts.pair[place] = {s, j, e, idle};
      contacts.pair_of[begin + k] = place;
      const int other = contacts.table.begin(j);
      int at = 0;
      while (contacts.table.partner[contacts.near[other + at]] != s) ++at;
      contacts.pair_of[other + at] = ~place;
    }
  }

  /// Notes what the last step has made of a contact; the force of one that is still there.
  LICHTENBERG_HOST_DEVICE void note_and_push(int number) const {
    const NearPair p = contacts.pair[number];
    contacts.force[number] = {};
    if (!(contacts.since[p.entry] >= 0)) return;
    const PairState<3> at = state(p);
    if (!stays(p, norm(at.apart))) return;
    const Vec3 push = force(p, at);
    contacts.force[number] = push;
    const double lighter = grains.mass[p.lower] < grains.mass[p.higher] ? grains.mass[p.lower] : grains.mass[p.higher];
    parallel::enlarge_atomically(&found->push, norm(push) / lighter);
  }
  LICHTENBERG_HOST_DEVICE void note(int number) const {
    const NearPair p = contacts.pair[number];
    if (contacts.since[p.entry] >= 0) stays(p, norm(apart(p)));
  }

  /// In the middle of a step grains are where the forces at its start carry them.
  LICHTENBERG_HOST_DEVICE void push_halfway(int number) const {
    NearPair& p = contacts.pair[number];
    const double dt = parameters->inner, h = 0.5 * dt;
    p.state = idle;
    contacts.halfway[number] = {};
    const bool touching = contacts.since[p.entry] >= 0;
    if (!touching && !may_come(p, dt)) return;
    const PairState<3> at = state(p);
    if (!touching && !may_touch(p, at, dt)) return;
    p.state = moving;
    contacts.active[parallel::take_place(&found->active)] = number;
    grains.busy[p.lower] = grains.busy[p.higher] = 1;
    const Vec3 acceleration = relative(contacts.force, p);
    contacts.first[number] = acceleration - contacts.force[number] / mass(p);
    contacts.halfway[number] =
        force(p, {at.apart + h * at.velocity + (0.5 * h * h) * acceleration, at.velocity + h * acceleration});
  }

  /// A pair by itself, with what its two feel of others linear in time.
  LICHTENBERG_HOST_DEVICE void integrate(int number, int step) const {
    NearPair& p = contacts.pair[number];
    const double dt = parameters->inner, time = parameters->begin + step * dt, reduced = mass(p);
    const PairState<3> at = state(p);
    const Vec3 first = contacts.first[number];
    const Vec3 middle = relative(contacts.halfway, p) - contacts.halfway[number] / reduced;
    const Outside<3> outside{first, (2 / dt) * (middle - first)};
    const Motion pair = motion(p, outside);
    const double since = contacts.since[p.entry], age = time - since;
    const bool touching = since >= 0;
    const PairStep<3> result = pair.over(at, touching, touching && age > 0 ? age : 0, dt);
    if (!touching && result.touched < 0) return;
    p.state = touching ? pushed : touched;
    contacts.impulse[number] = reduced * (result.end.velocity - at.velocity - outside.velocity(dt));
    contacts.shift[number] = reduced * (result.end.apart - at.apart - dt * at.velocity - outside.path(dt));
    contacts.dissipated[number] = result.dissipated;
    if (touching) return;
    contacts.since[p.entry] = time + result.touched;
    contacts.impact_speed[p.entry] = result.impact_speed;
    contacts.alone[p.entry] = 1;
  }

  LICHTENBERG_HOST_DEVICE void move(int s) const {
    const int begin = contacts.table.begin(s), count = grains.busy[s] ? contacts.count[s] : 0;
    const double dt = parameters->inner, m = grains.mass[s];
    const Vec3 held = grains.held[s], p0 = grains.momentum[s];
    Vec3 place = grains.place[s] + (dt / m) * (p0 + (0.5 * dt) * held), momentum = p0 + dt * held;
    int touches = 0, begun = 0;
    std::int64_t dissipated = 0;
    for (int k = 0; k < count; ++k) {
      const int of = contacts.pair_of[begin + k], number = of < 0 ? ~of : of;
      const NearPair p = contacts.pair[number];
      if (p.state < pushed) continue;
      ++touches;
      const bool first = of >= 0;
      place += (first ? -1 / m : 1 / m) * contacts.shift[number];
      momentum += first ? -contacts.impulse[number] : contacts.impulse[number];
      if (first) dissipated += static_cast<std::int64_t>(std::nearbyint(contacts.dissipated[number] / energy_quantum));
      if (p.state == pushed) continue;
      if (first) begin_contact(p, begun, contacts.impact_speed[p.entry]);
      ++begun;
    }
    grains.place[s] = place;
    grains.momentum[s] = momentum;
    grains.dissipated[s] += dissipated;
    grains.touches[s] = touches;
    grains.busy[s] = 0;
    if (exchanges) grains.collisions[s] += begun;
    if (s == 0) found->push = 0, found->active = 0;
  }

  /// The square of the largest speed that a contact may still give to its two.
  LICHTENBERG_HOST_DEVICE double impact2(int s) const {
    const int begin = contacts.table.begin(s), count = contacts.count[s];
    double most = 0;
    for (int k = 0; k < count; ++k) {
      const int of = contacts.pair_of[begin + k];
      if (of < 0) continue;
      const NearPair p = contacts.pair[of];
      if (!(contacts.since[p.entry] >= 0)) continue;
      const double overlap = reach(p) - norm(apart(p));
      if (overlap <= 0) continue;
      const double stored = law.parts(overlap, law.scale(grains.radius[p.lower], grains.radius[p.higher])).stored;
      const double impact2 = 2 * stored / mass(p);
      most = impact2 > most ? impact2 : most;
    }
    return most;
  }

 private:
  /// All forces on a grain, of which those of its contacts stand in `of`.
  LICHTENBERG_HOST_DEVICE Vec3 all(const Vec3* of, int s) const {
    const int begin = contacts.table.begin(s), count = contacts.count[s];
    Vec3 sum = grains.held[s];
    for (int k = 0; k < count; ++k) {
      const int pair = contacts.pair_of[begin + k];
      sum += pair < 0 ? of[~pair] : -of[pair];
    }
    return sum;
  }
  LICHTENBERG_HOST_DEVICE Vec3 relative(const Vec3* of, const NearPair& p) const {
    return all(of, p.higher) / grains.mass[p.higher] - all(of, p.lower) / grains.mass[p.lower];
  }

  /// Whether a contact is still one, at this distance.
  LICHTENBERG_HOST_DEVICE bool stays(const NearPair& p, double distance) const {
    const double sum = reach(p);
    if (grains.touches[p.lower] > 1 || grains.touches[p.higher] > 1) contacts.alone[p.entry] = 0;
    parallel::enlarge_atomically(&found->largest_overlap, (sum - distance) / sum);
    if (distance < too_close * sum) parallel::enlarge_atomically(&found->passed, 1 + grains.number[p.lower]);
    if (distance < sum) return true;
    contacts.since[p.entry] = -1;
    return false;
  }

  /// Whether two are near enough for a step, whatever their velocities.
  LICHTENBERG_HOST_DEVICE bool may_come(const NearPair& p, double dt) const {
    const double most = reach(p) + parameters->reach * dt / parameters->outer + slack(dt);
    return norm2(apart(p)) < most * most;
  }
  LICHTENBERG_HOST_DEVICE double slack(double dt) const { return (2 * found->push + parameters->held) * dt * dt; }

  /// Whether two in flight that what they feel bends come into reach within dt.
  LICHTENBERG_HOST_DEVICE bool may_touch(const NearPair& p, const PairState<3>& at, double dt) const {
    const double distance = reach(p) + slack(dt);
    const double approach = -dot(at.apart, at.velocity), v2 = norm2(at.velocity);
    const double t = approach <= 0 ? 0 : approach < v2 * dt ? approach / v2 : dt;
    return norm2(at.apart + t * at.velocity) < distance * distance;
  }

  /// A collision of its lower grain, the `before`-th in this step: charge moves, once, by the same random numbers as on
  /// the CPU (effects::ChargeExchange), which counts those of a step in ascending order of pairs as well.
  LICHTENBERG_HOST_DEVICE void begin_contact(const NearPair& p, int before, double speed) const {
    parallel::add_atomically(&found->begun, std::int64_t{1});
    if (!exchanges) return;
    const auto count = static_cast<std::uint64_t>(grains.collisions[p.lower] + before);
    Random random({seed, RandomPurpose::exchange, static_cast<std::uint64_t>(grains.number[p.lower]),
                   static_cast<std::uint64_t>(grains.number[p.higher]), count});
    const double quanta = std::nearbyint(exchange(mass(p), speed, random) / parameters->charge_quantum);
    const auto moved = static_cast<std::int64_t>(quanta);
    parallel::add_atomically(&grains.moved_charge[p.lower], moved);
    parallel::add_atomically(&grains.moved_charge[p.higher], -moved);
    parallel::add_atomically(&found->transfers, std::int64_t{1});
  }
};

}  // namespace lichtenberg::granular::device
