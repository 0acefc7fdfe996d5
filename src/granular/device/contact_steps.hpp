#pragma once

// The steps of contacts (../contact_motion.cpp) on an executor. Pairs that may matter within an outer step are listed,
// each once, and of them in each step of contacts those that do. What grains get from their pairs is added up in whole
// numbers: neither the order of lists nor that of threads shows.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "solvers/geometry/box.hpp"
#include "solvers/neighbours/table.hpp"
#include "src/effects/charge_exchange_law.hpp"
#include "src/granular/device/gas_parts.hpp"
#include "src/granular/device/restitution.hpp"
#include "src/granular/pair_motion.hpp"
#include "src/model/whole.hpp"

namespace lichtenberg::granular::device {

/// What sums of pairs are multiples of: powers of two.
struct Quanta {
  double force = 1, impulse = 1, shift = 1, energy = 1, charge = 1;

  Quanta inverse() const { return {1 / force, 1 / impulse, 1 / shift, 1 / energy, 1 / charge}; }
};

/// Of what grains have dissipated (m0 v0^2), of which a step of contacts of a pair is a whole number: a sum over all of
/// them has 52 bits of so much.
inline double energy_quantum(int grains) {
  return std::ldexp(1.0, -32 + std::max(0, static_cast<int>(std::ceil(std::log2(grains / 32768.0)))));
}

/// Where a grain is, for who looks for those near it.
struct alignas(16) Located {
  Turns at;
  float radius = 0;
};

/// Grains as they are sorted.
struct GrainsView {
  int count = 0;
  Vec3 *place = nullptr, *momentum = nullptr;
  TurnsAround* image = nullptr;
  double *charge = nullptr, *over_mass = nullptr, *radius = nullptr;
  Charged* charged = nullptr;  ///< for sums over charges
  int* number = nullptr;       ///< by which the scene knows it
  Located* located = nullptr;
  Turns* sorted_at = nullptr;
  Vec3* held = nullptr;  ///< forces of charges at the start of an outer step
  // What its pairs add up to within a step.
  WholeVec *force = nullptr, *halfway = nullptr, *impulse = nullptr, *shift = nullptr;
  int* busy = nullptr;                   ///< 1: some pair of its is active
  int* touches = nullptr;                ///< contacts of the last step
  int* begun = nullptr;                  ///< ends of pairs that have begun to touch, as a chain; no_end: none
  std::int64_t* collisions = nullptr;    ///< that have begun, while charge was exchanged
  std::int64_t* moved_charge = nullptr;  ///< quanta, that are still to be added to its charge
  std::int64_t* dissipated = nullptr;    ///< quanta of energy

  /// All that goes with a grain when it is sorted; `felt`: null if no charge feels anything.
  LICHTENBERG_HOST_DEVICE Grain take(int i, const Felt* felt) const {
    return {place[i],      momentum[i], charge[i],
            over_mass[i],  radius[i],   collisions[i],
            dissipated[i], charged[i],  felt ? felt[i] : Felt{},
            image[i],      number[i]};
  }
  LICHTENBERG_HOST_DEVICE void put(int s, const Grain& g, Felt* felt) const {
    place[s] = g.place, momentum[s] = g.momentum, charge[s] = g.charge, over_mass[s] = g.over_mass;
    radius[s] = g.radius, collisions[s] = g.collisions, dissipated[s] = g.dissipated, charged[s] = g.charged;
    if (felt) felt[s] = g.felt;
    image[s] = g.image, number[s] = g.number;
  }
};
constexpr int no_end = -1;

/// Two grains.
struct GrainPair {
  int lower = 0, higher = 0;  ///< where the two are sorted: that of the lower number first
};
/// A pair that may matter within an outer step.
struct alignas(16) NearPair : GrainPair {
  int entry = 0;  ///< of the table: what is known of a contact stands there
  int due = 0;    ///< the step of contacts from which on it may matter; open: in contact

  static constexpr int open = -1;
};
/// One that is computed in a step of contacts. Its ends are 2 k and 2 k + 1 if it is the k-th: lower and higher.
struct alignas(16) ActivePair : GrainPair {
  int near = 0;  ///< which near pair it is
  int touching = 0;
};

struct ContactsView {
  TableView table;                                   ///< each pair once
  int* owner = nullptr;                              ///< of an entry: whose row it is in
  double *since = nullptr, *impact_speed = nullptr;  ///< of an entry; no number of 0 or more: no contact
  int* alone = nullptr;

  NearPair* near = nullptr;
  ActivePair* active = nullptr;
  PairState<3>* seen = nullptr;                                 ///< of an active pair, at the start of a step
  double* scale = nullptr;                                      ///< of its law
  Vec3 *force = nullptr, *halfway = nullptr, *first = nullptr;  ///< on the higher; without it, relative
  int* next = nullptr;                                          ///< of an end: in the chain of its grain
};

/// What steps find, for the host.
struct Found {
  std::int64_t begun = 0, transfers = 0;
  double speed2 = 0;         ///< of the fastest grain
  double acceleration2 = 0;  ///< by charges
  double impact2 = 0;        ///< the square of the largest speed that a contact may still give to its two
  double moved2 = 0;         ///< of the grain that has moved most since grains were sorted
  double charge = 0;         ///< the largest magnitude
  int lost = 0;              ///< grains whose places are no numbers
  int pairs = 0, active = 0, ended = 0;
  int passed = 0;  ///< 1 + number of a grain through which another flew

  /// Nothing is known of the next step yet.
  LICHTENBERG_HOST_DEVICE void begin_step() {
    begun = transfers = 0;
    impact2 = 0;
    pairs = active = ended = 0;
  }
};
/// What is kept from step to step.
struct Extremes {
  double overlap = 0;  ///< over the sum of radii
};

struct StepParameters {
  double begin = 0;  ///< time at the start of the outer step
  double outer = 0;  ///< its length
  double inner = 0;  ///< that of a step of contacts
  double reach = 0;  ///< which pairs may matter within an outer step: gap between surfaces
  double bend = 0;   ///< acceleration that may bend a flight
  int steps = 0;     ///< of contacts
  int unused = 0;
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

  GrainsView grains;
  ContactsView contacts;
  Law law;
  NearestImage<3> nearest;
  float turn[3];  ///< lengths of the box, over 2^32
  const StepParameters* parameters;
  Found* found;
  Extremes* extremes;
  RestitutionCount restitution;
  effects::ImpactExchange exchange;
  Quanta quanta, over_quanta;
  std::uint64_t seed = 0;
  bool exchanges = false;

  LICHTENBERG_HOST_DEVICE double reach(const GrainPair& p) const {
    return grains.radius[p.lower] + grains.radius[p.higher];
  }
  /// 1 / reduced mass.
  LICHTENBERG_HOST_DEVICE double over_mass(const GrainPair& p) const {
    return grains.over_mass[p.lower] + grains.over_mass[p.higher];
  }
  LICHTENBERG_HOST_DEVICE Vec3 apart(const GrainPair& p) const {
    Vec3 r = grains.place[p.higher] - grains.place[p.lower];
    for (int k = 0; k < 3; ++k) r[k] = nearest(r[k], k);
    return r;
  }
  LICHTENBERG_HOST_DEVICE PairState<3> state(const GrainPair& p) const {
    return {apart(p), grains.over_mass[p.higher] * grains.momentum[p.higher] -
                          grains.over_mass[p.lower] * grains.momentum[p.lower]};
  }
  LICHTENBERG_HOST_DEVICE double scale(const GrainPair& p) const {
    return law.scale(grains.radius[p.lower], grains.radius[p.higher]);
  }

  /// Whether an entry's two may matter within an outer step.
  LICHTENBERG_HOST_DEVICE bool is_near(int e) const {
    return come_within(contacts.owner[e], contacts.table.partner[e], static_cast<float>(parameters->reach));
  }
  LICHTENBERG_HOST_DEVICE void list_near(int place, int e) const {
    const int i = contacts.owner[e], j = contacts.table.partner[e];
    const bool first = grains.number[i] < grains.number[j];
    contacts.near[place] = {{first ? i : j, first ? j : i}, e, contacts.since[e] >= 0 ? NearPair::open : 0};
  }

  // A step of contacts, one after the other.

  LICHTENBERG_HOST_DEVICE bool is_due(int k, int step) const { return contacts.near[k].due <= step; }
  /// A pair that is in contact, or may come to it, is active: notes what the last step has made of a contact, finds out
  /// whether this step moves it, and what its contact does at the start. One that is too far apart is looked at again
  /// when it may matter.
  LICHTENBERG_HOST_DEVICE void look(int k, int step) const {
    const NearPair p = contacts.near[k];
    const double dt = parameters->inner, slack = parameters->bend * dt * dt;
    const bool open = p.due == NearPair::open;
    if (!open && !may_matter(k, p, step)) return;
    const PairState<3> at = state(p);
    const bool touching = open && stays(k, p, norm2(at.apart), parameters->begin + step * dt);
    if (!touching && !may_touch(reach(p) + slack, at, dt)) return;
    const int a = parallel::take_place(&found->active);
    const double of_pair = scale(p);
    Vec3 push{};
    if (touching) push = motion(p, of_pair).force(at);
    contacts.active[a] = {{p.lower, p.higher}, k, touching};
    contacts.seen[a] = at;
    contacts.scale[a] = of_pair;
    contacts.force[a] = push;
    grains.busy[p.lower] = grains.busy[p.higher] = 1;
    if (touching) add(grains.force, p, over_quanta.force * push);
  }

  /// In the middle of a step grains are where the forces at its start carry them.
  LICHTENBERG_HOST_DEVICE void push_halfway(int a) const {
    const ActivePair p = contacts.active[a];
    const PairState<3> at = contacts.seen[a];
    const Vec3 acceleration = relative(grains.force, p);
    const Vec3 push = motion(p, contacts.scale[a]).force(carried(at, acceleration, 0.5 * parameters->inner));
    contacts.first[a] = acceleration - over_mass(p) * contacts.force[a];
    contacts.halfway[a] = push;
    grains.touches[p.lower] = grains.touches[p.higher] = 0;
    if (norm2(push) > 0) add(grains.halfway, p, over_quanta.force * push);
  }

  /// A pair by itself, with what its two feel of others linear in time.
  LICHTENBERG_HOST_DEVICE void integrate(int a, int step) const {
    const ActivePair p = contacts.active[a];
    const double dt = parameters->inner, time = parameters->begin + step * dt, over = over_mass(p);
    const PairState<3> at = contacts.seen[a];
    const Vec3 first = contacts.first[a], middle = relative(grains.halfway, p) - over * contacts.halfway[a];
    const auto outside = outside_through<3, double>(first, middle, dt);
    const int entry = contacts.near[p.near].entry;
    const double age = p.touching ? time - contacts.since[entry] : 0;
    const PairStep<3> result = motion(p, contacts.scale[a], outside).over(at, p.touching, age > 0 ? age : 0, dt);
    if (!p.touching && result.touched < 0) return;
    const auto [impulse, shift] = transfer(at, result.end, outside, 1 / over, dt);
    add(grains.impulse, p, over_quanta.impulse * impulse);
    add(grains.shift, p, over_quanta.shift * shift);
    parallel::add_atomically(&grains.dissipated[p.lower], whole(over_quanta.energy * result.dissipated));
    parallel::add_atomically(&grains.touches[p.lower], 1);
    parallel::add_atomically(&grains.touches[p.higher], 1);
    if (!p.touching) begin(a, p, time, result);
  }
  LICHTENBERG_HOST_DEVICE void begin(int a, const ActivePair& p, double time, const PairStep<3>& result) const {
    NearPair& near = contacts.near[p.near];
    near.due = NearPair::open;
    contacts.since[near.entry] = time + result.touched;
    contacts.impact_speed[near.entry] = result.impact_speed;
    contacts.alone[near.entry] = 1;
    parallel::add_atomically(&found->begun, std::int64_t{1});
    if (!exchanges) return;
    contacts.next[2 * a] = parallel::exchange_atomically(&grains.begun[p.lower], 2 * a);
    contacts.next[2 * a + 1] = parallel::exchange_atomically(&grains.begun[p.higher], 2 * a + 1);
  }

  /// The k-th of all components of two sums, when they have been read and before something is added to them. Threads
  /// beside each other then write whole sectors of memory; parts of them a device would read first.
  LICHTENBERG_HOST_DEVICE static void clear(WholeVec* one, WholeVec* other, int k) {
    (&one->x)[k] = (&other->x)[k] = 0;
  }
  LICHTENBERG_HOST_DEVICE void move(int s) const {
    const double dt = parameters->inner, over = grains.over_mass[s];
    Vec3 place = grains.place[s], momentum = grains.momentum[s];
    fly(place, momentum, grains.held[s], over, dt);
    if (grains.busy[s]) {
      place += over * grains.shift[s].times(quanta.shift);
      momentum += grains.impulse[s].times(quanta.impulse);
      grains.busy[s] = 0;
      if (exchanges && grains.begun[s] != no_end) begin_contacts(s);
    }
    grains.place[s] = place;
    grains.momentum[s] = momentum;
    locate(s, place);
  }
  LICHTENBERG_HOST_DEVICE void locate(int s, Vec3 place) const {
    grains.located[s].at = turns_of(place, whole_turn * nearest.turns_a_metre);
  }

  /// After the last step of contacts: notes as above, and the square of the largest speed that a contact may still give
  /// to its two.
  LICHTENBERG_HOST_DEVICE double impact2(int k) const {
    const NearPair p = contacts.near[k];
    if (p.due != NearPair::open) return 0;
    const double distance2 = norm2(apart(p));
    if (!stays(k, p, distance2, parameters->begin + parameters->outer)) return 0;
    return 2 * over_mass(p) * law.push(reach(p) - root_of(distance2), scale(p)).stored;
  }

  /// The k-th of those that have ended within the outer step, if there are so many.
  LICHTENBERG_HOST_DEVICE void count_end(int k) const {
    if (k >= found->ended) return;
    const EndedContact contact = restitution.ended[k];
    const GrainPair p{contact.lower, contact.higher};
    restitution.count(law, scale(p), 1 / over_mass(p), reach(p), contact);
  }

 private:
  /// Whether two are so near that they may come into contact in this step; if not, notes when they may.
  LICHTENBERG_HOST_DEVICE bool may_matter(int k, const NearPair& p, int step) const {
    const double dt = parameters->inner;
    const auto path = static_cast<float>(parameters->reach * dt / parameters->outer);
    const float least = gap(p.lower, p.higher) - static_cast<float>(parameters->bend * dt * dt);
    if (least < path) return true;
    // Nearer by less than the path in a step; rounding leaves the number of steps a little too small.
    const float steps = least / (path * (1 + 1e-5f));
    if (steps >= 1) contacts.near[k].due = step + (steps < 1e6f ? static_cast<int>(steps) : 1000000);
    return false;
  }
  /// Whether the gap between two is less than `gap`, or by rounding hardly more.
  LICHTENBERG_HOST_DEVICE bool come_within(int i, int j, float gap) const {
    const Located a = grains.located[i], b = grains.located[j];
    const float most = (a.radius + b.radius + gap) * (1 + 1e-5f);
    return distance2(a, b) < most * most;
  }
  /// Between two, or by rounding a little less.
  LICHTENBERG_HOST_DEVICE float gap(int i, int j) const {
    const Located a = grains.located[i], b = grains.located[j];
    const float square = distance2(a, b) * (1 - 2e-5f);
    return std::sqrt(square) - (a.radius + b.radius);
  }
  LICHTENBERG_HOST_DEVICE float distance2(const Located& a, const Located& b) const {
    const float x = turn[0] * lichtenberg::apart(a.at.x, b.at.x), y = turn[1] * lichtenberg::apart(a.at.y, b.at.y),
                z = turn[2] * lichtenberg::apart(a.at.z, b.at.z);
    return x * x + y * y + z * z;
  }
  LICHTENBERG_HOST_DEVICE Motion motion(const GrainPair& p, double scale, const Outside<3>& outside = {}) const {
    return {{law, scale}, reach(p), over_mass(p), outside};
  }

  /// To both of a pair, of what is done to the higher.
  LICHTENBERG_HOST_DEVICE static void add(WholeVec* to, const GrainPair& p, Vec3 quanta) {
    const std::int64_t x = whole(quanta.x), y = whole(quanta.y), z = whole(quanta.z);
    parallel::add_atomically(&to[p.higher].x, x), parallel::add_atomically(&to[p.lower].x, -x);
    parallel::add_atomically(&to[p.higher].y, y), parallel::add_atomically(&to[p.lower].y, -y);
    parallel::add_atomically(&to[p.higher].z, z), parallel::add_atomically(&to[p.lower].z, -z);
  }
  /// The relative acceleration by all forces, of which those of contacts are `of`.
  LICHTENBERG_HOST_DEVICE Vec3 relative(const WholeVec* of, const GrainPair& p) const {
    const double lower = grains.over_mass[p.lower], higher = grains.over_mass[p.higher];
    return higher * (grains.held[p.higher] + of[p.higher].times(quanta.force)) -
           lower * (grains.held[p.lower] + of[p.lower].times(quanta.force));
  }

  /// Whether a contact is still one, at this distance and time.
  LICHTENBERG_HOST_DEVICE bool stays(int k, const NearPair& p, double distance2, double time) const {
    const double sum = reach(p), distance = root_of(distance2);
    if (grains.touches[p.lower] > 1 || grains.touches[p.higher] > 1) contacts.alone[p.entry] = 0;
    parallel::enlarge_atomically(&extremes->overlap, (sum - distance) / sum);
    if (distance < too_close * sum) parallel::enlarge_atomically(&found->passed, 1 + grains.number[p.lower]);
    if (distance < sum) return true;
    if (contacts.alone[p.entry]) note_end(p, time);
    contacts.since[p.entry] = -1;
    contacts.near[k].due = 0;
    return false;
  }

  LICHTENBERG_HOST_DEVICE void note_end(const NearPair& p, double time) const {
    const PairState<3> at = state(p);
    const double began = contacts.since[p.entry];
    restitution.note(
        &found->ended,
        {{began, time - began, contacts.impact_speed[p.entry], -closing(at), speed_across(at)}, p.lower, p.higher});
  }

  /// Whether two in flight come closer than `distance` within dt.
  LICHTENBERG_HOST_DEVICE static bool may_touch(double distance, const PairState<3>& at, double dt) {
    const double approach = -dot(at.apart, at.velocity), v2 = norm2(at.velocity);
    const double t = approach <= 0 ? 0 : approach < v2 * dt ? approach / v2 : dt;
    return norm2(at.apart + t * at.velocity) < distance * distance;
  }

  /// Contacts of a grain that have begun in this step: those in which it is the lower move charge, once, by the same
  /// random numbers as on the CPU (effects::ChargeExchange), which counts those of a step in ascending order of pairs.
  LICHTENBERG_HOST_DEVICE void begin_contacts(int s) const {
    int count = 0;
    for (int end = grains.begun[s]; end != no_end; end = contacts.next[end]) {
      ++count;
      if (end % 2) continue;
      int before = 0;
      for (int other = grains.begun[s]; other != no_end; other = contacts.next[other])
        before += partner(other) < partner(end);
      exchange_charge(end / 2, grains.collisions[s] + before);
    }
    grains.collisions[s] += count;
    grains.begun[s] = no_end;
  }
  /// The number of the grain at the other end.
  LICHTENBERG_HOST_DEVICE int partner(int end) const {
    const GrainPair& p = contacts.active[end / 2];
    return grains.number[end % 2 ? p.lower : p.higher];
  }
  LICHTENBERG_HOST_DEVICE void exchange_charge(int a, std::int64_t count) const {
    const ActivePair p = contacts.active[a];
    const int entry = contacts.near[p.near].entry;
    Random random({seed, RandomPurpose::exchange, static_cast<std::uint64_t>(grains.number[p.lower]),
                   static_cast<std::uint64_t>(grains.number[p.higher]), static_cast<std::uint64_t>(count)});
    const std::int64_t moved = whole(exchange(1 / over_mass(p), contacts.impact_speed[entry], random) / quanta.charge);
    parallel::add_atomically(&grains.moved_charge[p.lower], moved);
    parallel::add_atomically(&grains.moved_charge[p.higher], -moved);
    parallel::add_atomically(&found->transfers, std::int64_t{1});
  }
};

}  // namespace lichtenberg::granular::device
