#pragma once

// Contact substeps (../contact_motion.cpp) on an executor. An outer step lists its candidate pairs, each once, and each
// substep selects the active ones. Sums over the pairs of a grain are integers, so results do not depend on the order
// of lists and threads. The formulas of a pair are those of the CPU (../pair_motion.hpp). The sequence differs, because
// a device processes all pairs in parallel phases.

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
#include "src/model/fixed_point_vec.hpp"

namespace lichtenberg::granular::device {

/// Units of the integer sums over pairs (fixed-point scales): powers of two, in reduced units.
struct FixedPointScale {
  double force = 1, impulse = 1, shift = 1, energy = 1, charge = 1;

  FixedPointScale inverse() const { return {1 / force, 1 / impulse, 1 / shift, 1 / energy, 1 / charge}; }
};

/// Unit (m0 v0^2) of the dissipated energy of a pair in a substep. The sum over all grains fits into 52 bits.
inline double energy_quantum(int grains) {
  return std::ldexp(1.0, -32 + std::max(0, static_cast<int>(std::ceil(std::log2(grains / 32768.0)))));
}

/// Position and radius of a grain in compact form, for neighbour searches.
struct alignas(16) CompactGrain {
  FixedPointPosition at;
  float radius = 0;
};

/// Device pointers to the arrays of grains, in sorted order.
struct GrainsView {
  int count = 0;
  Vec3 *position = nullptr, *momentum = nullptr;
  ImageCount* image = nullptr;
  double *charge = nullptr, *inverse_mass = nullptr, *radius = nullptr;
  PointCharge* charged = nullptr;  ///< input of the sums over charges
  int* number = nullptr;           ///< index of the grain in the scene
  CompactGrain* compact = nullptr;
  FixedPointPosition* sorted_at = nullptr;
  Vec3* slow_force = nullptr;  ///< smooth forces at the start of an outer step
  // Sums over the pairs of a grain in a substep, in units of FixedPointScale.
  FixedPointVec *force = nullptr, *halfway = nullptr, *impulse = nullptr, *shift = nullptr;
  int* busy = nullptr;                   ///< 1: the grain has an active pair
  int* touches = nullptr;                ///< number of contacts in the last substep
  int* begun = nullptr;                  ///< head of the linked list of new contacts; no_end: none
  std::int64_t* collisions = nullptr;    ///< number of onsets, while charge was exchanged
  std::int64_t* moved_charge = nullptr;  ///< quanta to be added to the charge
  std::int64_t* dissipated = nullptr;    ///< quanta of energy

  /// Returns the data of a grain that sorting moves. `field_at_source`: fields at the charges, or null.
  LICHTENBERG_HOST_DEVICE Grain take(int i, const FieldSample* field_at_source) const {
    return {position[i],     momentum[i], charge[i],
            inverse_mass[i], radius[i],   collisions[i],
            dissipated[i],   charged[i],  field_at_source ? field_at_source[i] : FieldSample{},
            image[i],        number[i]};
  }
  LICHTENBERG_HOST_DEVICE void put(int s, const Grain& g, FieldSample* field_at_source) const {
    position[s] = g.position, momentum[s] = g.momentum, charge[s] = g.charge, inverse_mass[s] = g.inverse_mass;
    radius[s] = g.radius, collisions[s] = g.collisions, dissipated[s] = g.dissipated, charged[s] = g.charged;
    if (field_at_source) field_at_source[s] = g.field_at_source;
    image[s] = g.image, number[s] = g.number;
  }
};
constexpr int no_end = -1;

/// A pair of grains.
struct GrainPair {
  int lower = 0, higher = 0;  ///< sorted indices; the grain with the lower number is first
};
/// A candidate pair of an outer step.
struct alignas(16) NearPair : GrainPair {
  int entry = 0;  ///< entry of the table, where the contact's data are
  int due = 0;    ///< first substep in which it may touch; open: in contact

  static constexpr int open = -1;
};
/// An active pair of a substep. The k-th has the ends 2 k (lower grain) and 2 k + 1 (higher grain).
struct alignas(16) ActivePair : GrainPair {
  int near = 0;  ///< index of the candidate pair
  int touching = 0;
};

struct ContactsView {
  TableView table;                                   ///< neighbour table with each pair once
  int* owner = nullptr;                              ///< [entries], grain of the row
  double *since = nullptr, *impact_speed = nullptr;  ///< [entries]; since: negative or NaN without contact
  int* alone = nullptr;

  NearPair* near = nullptr;
  ActivePair* active = nullptr;
  PairState<3>* state = nullptr;  ///< state of an active pair at the start of a substep
  double* scale = nullptr;        ///< factor of the law
  /// Forces on the higher grain; first: relative acceleration by all other contacts.
  Vec3 *force = nullptr, *halfway = nullptr, *first = nullptr;
  int* next = nullptr;  ///< [ends], next in the linked list of its grain
};

/// Results of steps, for the host; reduced units.
struct StepResults {
  std::int64_t begun = 0, transfers = 0;
  double speed2 = 0;         ///< of the fastest grain
  double acceleration2 = 0;  ///< largest by smooth forces
  double impact2 = 0;        ///< square of the largest speed that a contact may give to its grains
  double moved2 = 0;         ///< square of the largest displacement since the last sorting
  double charge = 0;         ///< largest magnitude
  int lost = 0;              ///< not 0: some position is NaN
  int pairs = 0, active = 0, ended = 0;
  int passed = 0;  ///< 1 + number of a grain through which another has passed; 0: none

  /// Resets the results of a single step.
  LICHTENBERG_HOST_DEVICE void begin_step() {
    begun = transfers = 0;
    impact2 = 0;
    pairs = active = ended = 0;
  }
};
/// Maxima over all steps.
struct Extremes {
  double overlap = 0;  ///< relative to the sum of radii
};

struct StepParameters {
  double begin = 0;             ///< t0, start of the outer step
  double outer = 0;             ///< t0, its length
  double inner = 0;             ///< t0, length of a substep
  double reach = 0;             ///< d0, largest gap of candidate pairs
  double max_acceleration = 0;  ///< bound on relative accelerations
  int steps = 0;                ///< number of substeps
  int unused = 0;
};

template <class Law>
struct LawOfPair {
  Law law;
  double scale;
  LICHTENBERG_HOST_DEVICE ContactForceTerms<double> operator()(double overlap) const {
    return law.force_terms(overlap, scale);
  }
};

template <class Law>
struct ContactSteps {
  using Motion = PairMotion<3, LawOfPair<Law>>;

  GrainsView grains;
  ContactsView contacts;
  Law law;
  NearestImage<3> nearest;
  float unit_length[3];  ///< lengths of the box, over 2^32
  const StepParameters* parameters;
  StepResults* results;
  Extremes* extremes;
  RestitutionCount restitution;
  effects::ImpactExchange exchange;
  FixedPointScale units, inverse_units;
  std::uint64_t seed = 0;
  bool exchanges = false;

  LICHTENBERG_HOST_DEVICE double reach(const GrainPair& p) const {
    return grains.radius[p.lower] + grains.radius[p.higher];
  }
  /// 1 / reduced mass.
  LICHTENBERG_HOST_DEVICE double inverse_mass(const GrainPair& p) const {
    return grains.inverse_mass[p.lower] + grains.inverse_mass[p.higher];
  }
  LICHTENBERG_HOST_DEVICE Vec3 separation(const GrainPair& p) const {
    Vec3 r = grains.position[p.higher] - grains.position[p.lower];
    for (int k = 0; k < 3; ++k) r[k] = nearest(r[k], k);
    return r;
  }
  LICHTENBERG_HOST_DEVICE PairState<3> state(const GrainPair& p) const {
    return {separation(p), grains.inverse_mass[p.higher] * grains.momentum[p.higher] -
                               grains.inverse_mass[p.lower] * grains.momentum[p.lower]};
  }
  LICHTENBERG_HOST_DEVICE double scale(const GrainPair& p) const {
    return law.scale(grains.radius[p.lower], grains.radius[p.higher]);
  }

  /// Returns true if the pair of an entry may touch within an outer step.
  LICHTENBERG_HOST_DEVICE bool is_near(int e) const {
    return come_within(contacts.owner[e], contacts.table.partner[e], static_cast<float>(parameters->reach));
  }
  LICHTENBERG_HOST_DEVICE void list_near(int index, int e) const {
    const int i = contacts.owner[e], j = contacts.table.partner[e];
    const bool first = grains.number[i] < grains.number[j];
    contacts.near[index] = {{first ? i : j, first ? j : i}, e, contacts.since[e] >= 0 ? NearPair::open : 0};
  }

  // The phases of a substep.

  LICHTENBERG_HOST_DEVICE bool is_due(int k, int step) const { return contacts.near[k].due <= step; }
  /// Ends a contact whose pair has separated, and adds the pair to the active ones if it is in contact or may touch in
  /// this substep. Adds the contact force at the start to both grains. A pair that is too far apart is due again when
  /// it may touch.
  LICHTENBERG_HOST_DEVICE void activate_pair(int k, int step) const {
    const NearPair p = contacts.near[k];
    const double dt = parameters->inner, slack = parameters->max_acceleration * dt * dt;
    const bool open = p.due == NearPair::open;
    if (!open && !may_come_into_contact(k, p, step)) return;
    const PairState<3> at = state(p);
    const bool touching = open && continues(k, p, norm2(at.separation), parameters->begin + step * dt);
    if (!touching && !may_touch(reach(p) + slack, at, dt)) return;
    const int a = parallel::take_index(&results->active);
    const double pair_scale = scale(p);
    Vec3 force{};
    if (touching) force = motion(p, pair_scale).force(at);
    contacts.active[a] = {{p.lower, p.higher}, k, touching};
    contacts.state[a] = at;
    contacts.scale[a] = pair_scale;
    contacts.force[a] = force;
    grains.busy[p.lower] = grains.busy[p.higher] = 1;
    if (touching) add(grains.force, p, inverse_units.force * force);
  }

  /// Adds the contact force in the middle of the substep, at positions that follow from the forces at its start.
  LICHTENBERG_HOST_DEVICE void add_halfway_force(int a) const {
    const ActivePair p = contacts.active[a];
    const PairState<3> at = contacts.state[a];
    const Vec3 acceleration = relative(grains.force, p);
    const Vec3 force = motion(p, contacts.scale[a]).force(accelerated(at, acceleration, 0.5 * parameters->inner));
    contacts.first[a] = acceleration - inverse_mass(p) * contacts.force[a];
    contacts.halfway[a] = force;
    grains.touches[p.lower] = grains.touches[p.higher] = 0;
    if (norm2(force) > 0) add(grains.halfway, p, inverse_units.force * force);
  }

  /// Integrates a pair separately, with the acceleration by all others linear in time.
  LICHTENBERG_HOST_DEVICE void integrate(int a, int step) const {
    const ActivePair p = contacts.active[a];
    const double dt = parameters->inner, time = parameters->begin + step * dt, over = inverse_mass(p);
    const PairState<3> at = contacts.state[a];
    const Vec3 first = contacts.first[a], middle = relative(grains.halfway, p) - over * contacts.halfway[a];
    const auto external = external_from_values<3, double>(first, middle, dt);
    const int entry = contacts.near[p.near].entry;
    const double age = p.touching ? time - contacts.since[entry] : 0;
    const PairStep<3> result = motion(p, contacts.scale[a], external).integrate(at, p.touching, age > 0 ? age : 0, dt);
    if (!p.touching && result.onset < 0) return;
    const auto [impulse, shift] = transfer(at, result.end, external, 1 / over, dt);
    add(grains.impulse, p, inverse_units.impulse * impulse);
    add(grains.shift, p, inverse_units.shift * shift);
    parallel::add_atomically(&grains.dissipated[p.lower], rounded_to_integer(inverse_units.energy * result.dissipated));
    parallel::add_atomically(&grains.touches[p.lower], 1);
    parallel::add_atomically(&grains.touches[p.higher], 1);
    if (!p.touching) begin(a, p, time, result);
  }
  LICHTENBERG_HOST_DEVICE void begin(int a, const ActivePair& p, double time, const PairStep<3>& result) const {
    NearPair& near = contacts.near[p.near];
    near.due = NearPair::open;
    contacts.since[near.entry] = time + result.onset;
    contacts.impact_speed[near.entry] = result.impact_speed;
    contacts.alone[near.entry] = 1;
    parallel::add_atomically(&results->begun, std::int64_t{1});
    if (!exchanges) return;
    contacts.next[2 * a] = parallel::exchange_atomically(&grains.begun[p.lower], 2 * a);
    contacts.next[2 * a + 1] = parallel::exchange_atomically(&grains.begun[p.higher], 2 * a + 1);
  }

  /// Clears the k-th component of two sums between their use and the next additions. Adjacent threads write complete
  /// memory sectors; a device would read partly written ones first.
  LICHTENBERG_HOST_DEVICE static void clear(FixedPointVec* one, FixedPointVec* other, int k) {
    (&one->x)[k] = (&other->x)[k] = 0;
  }
  LICHTENBERG_HOST_DEVICE void move(int s) const {
    const double dt = parameters->inner, over = grains.inverse_mass[s];
    Vec3 position = grains.position[s], momentum = grains.momentum[s];
    fly(position, momentum, grains.slow_force[s], over, dt);
    if (grains.busy[s]) {
      position += over * grains.shift[s].times(units.shift);
      momentum += grains.impulse[s].times(units.impulse);
      grains.busy[s] = 0;
      if (exchanges && grains.begun[s] != no_end) begin_contacts(s);
    }
    grains.position[s] = position;
    grains.momentum[s] = momentum;
    locate(s, position);
  }
  LICHTENBERG_HOST_DEVICE void locate(int s, Vec3 position) const {
    grains.compact[s].at = fixed_point_position(position, units_per_box * nearest.inverse_length);
  }

  /// After the last substep: ends contacts of separated pairs, and returns the square of the largest speed that a
  /// contact may give to its grains.
  LICHTENBERG_HOST_DEVICE double impact2(int k) const {
    const NearPair p = contacts.near[k];
    if (p.due != NearPair::open) return 0;
    const double distance2 = norm2(separation(p));
    if (!continues(k, p, distance2, parameters->begin + parameters->outer)) return 0;
    return 2 * inverse_mass(p) * law.force_terms(reach(p) - root_of(distance2), scale(p)).stored;
  }

  /// Counts the k-th ended contact of the outer step, if there is one.
  LICHTENBERG_HOST_DEVICE void count_end(int k) const {
    if (k >= results->ended) return;
    const EndedContact contact = restitution.ended[k];
    const GrainPair p{contact.lower, contact.higher};
    restitution.count(law, scale(p), 1 / inverse_mass(p), reach(p), contact);
  }

 private:
  /// Returns true if a pair may come into contact in this substep; if not, sets when it is due.
  LICHTENBERG_HOST_DEVICE bool may_come_into_contact(int k, const NearPair& p, int step) const {
    const double dt = parameters->inner;
    const auto path = static_cast<float>(parameters->reach * dt / parameters->outer);
    const float least = gap(p.lower, p.higher) - static_cast<float>(parameters->max_acceleration * dt * dt);
    if (least < path) return true;
    // A substep shortens the gap by less than `path`. The factor covers rounding.
    const float steps = least / (path * (1 + 1e-5f));
    if (steps >= 1) contacts.near[k].due = step + (steps < 1e6f ? static_cast<int>(steps) : 1000000);
    return false;
  }
  /// Returns true if the gap of two grains is less than `gap`; rounding is on the safe side.
  LICHTENBERG_HOST_DEVICE bool come_within(int i, int j, float gap) const {
    const CompactGrain a = grains.compact[i], b = grains.compact[j];
    const float most = (a.radius + b.radius + gap) * (1 + 1e-5f);
    return distance2(a, b) < most * most;
  }
  /// Returns the gap of two grains, or by rounding slightly less.
  LICHTENBERG_HOST_DEVICE float gap(int i, int j) const {
    const CompactGrain a = grains.compact[i], b = grains.compact[j];
    const float square = distance2(a, b) * (1 - 2e-5f);
    return std::sqrt(square) - (a.radius + b.radius);
  }
  LICHTENBERG_HOST_DEVICE float distance2(const CompactGrain& a, const CompactGrain& b) const {
    const float x = unit_length[0] * lichtenberg::nearest_difference(a.at.x, b.at.x),
                y = unit_length[1] * lichtenberg::nearest_difference(a.at.y, b.at.y),
                z = unit_length[2] * lichtenberg::nearest_difference(a.at.z, b.at.z);
    return x * x + y * y + z * z;
  }
  LICHTENBERG_HOST_DEVICE Motion motion(const GrainPair& p, double scale,
                                        const ExternalAcceleration<3>& external = {}) const {
    return {{law, scale}, reach(p), inverse_mass(p), external};
  }

  /// Adds a quantity to the sum of the higher grain, and subtracts it from that of the lower one.
  LICHTENBERG_HOST_DEVICE static void add(FixedPointVec* to, const GrainPair& p, Vec3 value) {
    const std::int64_t x = rounded_to_integer(value.x), y = rounded_to_integer(value.y),
                       z = rounded_to_integer(value.z);
    parallel::add_atomically(&to[p.higher].x, x), parallel::add_atomically(&to[p.lower].x, -x);
    parallel::add_atomically(&to[p.higher].y, y), parallel::add_atomically(&to[p.lower].y, -y);
    parallel::add_atomically(&to[p.higher].z, z), parallel::add_atomically(&to[p.lower].z, -z);
  }
  /// Returns the relative acceleration by slow forces and the contact forces `of`.
  LICHTENBERG_HOST_DEVICE Vec3 relative(const FixedPointVec* of, const GrainPair& p) const {
    const double lower = grains.inverse_mass[p.lower], higher = grains.inverse_mass[p.higher];
    return higher * (grains.slow_force[p.higher] + of[p.higher].times(units.force)) -
           lower * (grains.slow_force[p.lower] + of[p.lower].times(units.force));
  }

  /// Returns true if a contact continues at this distance and time, and records its end otherwise.
  LICHTENBERG_HOST_DEVICE bool continues(int k, const NearPair& p, double distance2, double time) const {
    const double sum = reach(p), distance = root_of(distance2);
    if (grains.touches[p.lower] > 1 || grains.touches[p.higher] > 1) contacts.alone[p.entry] = 0;
    parallel::max_atomically(&extremes->overlap, (sum - distance) / sum);
    if (distance < too_close * sum) parallel::max_atomically(&results->passed, 1 + grains.number[p.lower]);
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
        &results->ended,
        {{began, time - began, contacts.impact_speed[p.entry], -closing(at), speed_across(at)}, p.lower, p.higher});
  }

  /// Returns true if two grains in straight flight come closer than `distance` within dt.
  LICHTENBERG_HOST_DEVICE static bool may_touch(double distance, const PairState<3>& at, double dt) {
    const double approach = -dot(at.separation, at.velocity), v2 = norm2(at.velocity);
    const double t = approach <= 0 ? 0 : approach < v2 * dt ? approach / v2 : dt;
    return norm2(at.separation + t * at.velocity) < distance * distance;
  }

  /// Exchanges charge in the new contacts of a grain in which it is the lower one. Random numbers are those of the CPU
  /// (effects::ChargeExchange), where the count of a contact follows from the ascending order of pairs in a step.
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
  /// Returns the number of the grain at the other end.
  LICHTENBERG_HOST_DEVICE int partner(int end) const {
    const GrainPair& p = contacts.active[end / 2];
    return grains.number[end % 2 ? p.lower : p.higher];
  }
  LICHTENBERG_HOST_DEVICE void exchange_charge(int a, std::int64_t count) const {
    const ActivePair p = contacts.active[a];
    const int entry = contacts.near[p.near].entry;
    Random random({seed, RandomPurpose::exchange, static_cast<std::uint64_t>(grains.number[p.lower]),
                   static_cast<std::uint64_t>(grains.number[p.higher]), static_cast<std::uint64_t>(count)});
    const std::int64_t moved =
        rounded_to_integer(exchange(1 / inverse_mass(p), contacts.impact_speed[entry], random) / units.charge);
    parallel::add_atomically(&grains.moved_charge[p.lower], moved);
    parallel::add_atomically(&grains.moved_charge[p.higher], -moved);
    parallel::add_atomically(&results->transfers, std::int64_t{1});
  }
};

}  // namespace lichtenberg::granular::device
