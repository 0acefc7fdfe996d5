#pragma once

// Contact substeps (../contact_motion.cpp) on an executor. An outer step lists its candidate pairs, each once, and each
// substep selects the active ones. Sums over the pairs of a grain are integers, so results do not depend on the order
// of lists and threads. The formulas of a pair are those of the CPU (../pair_motion.hpp). The sequence differs, because
// a device processes all pairs in parallel phases.

#include <cmath>
#include <cstdint>

#include "solvers/geometry/box.hpp"
#include "src/effects/charge_exchange_law.hpp"
#include "src/granular/device/contact_data.hpp"
#include "src/granular/device/restitution.hpp"
#include "src/granular/device/rough_law.hpp"
#include "src/granular/device/share.hpp"
#include "src/granular/pair_motion.hpp"
#include "src/model/fixed_point_vec.hpp"

namespace lichtenberg::granular::device {

/// Contact law of one pair: the law of all grains, and the factor `scale` of its forces, which follows from the radii
/// of the pair.
template <class Law>
struct LawOfPair {
  Law law;
  double scale;
  LICHTENBERG_HOST_DEVICE ContactForceTerms<double> operator()(double overlap) const {
    return law.force_terms(overlap, scale);
  }
};

/// Contact substeps of an outer step (from one evaluation of the smooth forces to the next) on a device, as functions
/// for single grains and pairs that kernels call. A substep runs activate_pair() for the due candidate pairs, then
/// add_halfway_force() and integrate() for active pairs. move() moves each grain after the integration of its active
/// pairs. Reduced units.
template <class Law>
struct ContactSteps {
  using Motion = PairMotion<3, LawOfPair<Law>>;

  GrainsView grains;
  ContactsView contacts;
  Law law;
  NearestImage<3> nearest;
  float unit_length[3];  ///< search lengths, over 2^32
  const StepParameters* parameters;
  StepResults* results;
  Extremes* extremes;
  RestitutionCount restitution;
  effects::ImpactExchange exchange;
  FixedPointScale units, inverse_units;
  std::uint64_t seed = 0;
  bool exchanges = false;
  Vec3 units_per_length;    ///< 2^32 over the search lengths (1/d0)
  ShareOfGrains range;      ///< grains of this rank
  bool is_divided = false;  ///< true if there are several ranks

  /// Returns the sum of the radii of a pair (d0).
  LICHTENBERG_HOST_DEVICE double reach(const GrainPair& p) const {
    return grains.radius[p.lower] + grains.radius[p.higher];
  }
  /// Returns 1 / (reduced mass) of a pair.
  LICHTENBERG_HOST_DEVICE double inverse_mass(const GrainPair& p) const {
    return grains.inverse_mass[p.lower] + grains.inverse_mass[p.higher];
  }
  /// Returns the vector from the lower grain to the nearest image of the higher grain (d0).
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

  /// Returns true if the pair of entry e of the neighbour table is in contact or may touch within the outer step. An
  /// outer step lasts from one evaluation of the smooth forces to the next.
  LICHTENBERG_HOST_DEVICE bool is_near(int e) const {
    return come_within(contacts.owner[e], contacts.table.partner[e], static_cast<float>(parameters->reach));
  }
  /// Makes the pair of entry e of the neighbour table the candidate pair `index`.
  LICHTENBERG_HOST_DEVICE void list_near(int index, int e) const {
    const int i = contacts.owner[e], j = contacts.table.partner[e];
    const bool first = grains.number[i] < grains.number[j];
    contacts.near[index] = {{first ? i : j, first ? j : i}, e, contacts.since[e] >= 0 ? NearPair::open : 0};
  }

  // The phases of a substep.

  /// Returns true if candidate pair k is in contact, or must be examined in substep `step` because it may touch.
  LICHTENBERG_HOST_DEVICE bool is_due(int k, int step) const { return contacts.near[k].due <= step; }
  /// Begins a substep for candidate pair k. Ends its contact if the grains have separated. Makes the pair active if it
  /// is in contact or may touch in this substep. Adds the contact force at the start, if any, to both grains. A pair
  /// with a large gap is due again when it may touch.
  LICHTENBERG_HOST_DEVICE void activate_pair(int k, int step) const {
    const NearPair p = contacts.near[k];
    const double dt = parameters->inner, slack = parameters->max_acceleration * dt * dt;
    const bool open = is_open(p);
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

  /// Adds the contact force of active pair a in the middle of the substep to both grains. The positions in the middle
  /// follow from the forces at the start of the substep.
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

  /// Integrates active pair a over a substep and adds the impulse and shift of its contact to both grains. The relative
  /// acceleration by all other forces is linear in time.
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
  /// Records the onset of a contact of active pair a in a substep that begins at `time`.
  LICHTENBERG_HOST_DEVICE void begin(int a, const ActivePair& p, double time, const PairStep<3>& result) const {
    NearPair& near = contacts.near[p.near];
    near.due = NearPair::open;
    contacts.since[near.entry] = time + result.onset;
    contacts.impact_speed[near.entry] = result.impact_speed;
    contacts.alone[near.entry] = 1;
    if (is_own(near)) parallel::add_atomically(&results->begun, std::int64_t{1});
    if (contacts.onset) list_onset(time, p.near, result.impact_speed);
    if (!exchanges) return;
    contacts.next[2 * a] = parallel::exchange_atomically(&grains.begun[p.lower], 2 * a);
    contacts.next[2 * a + 1] = parallel::exchange_atomically(&grains.begun[p.higher], 2 * a + 1);
  }

  /// Clears the k-th number of two arrays of sums between their use and the next additions. Adjacent threads thus write
  /// complete memory sectors; a device would first read sectors that are written only in part.
  LICHTENBERG_HOST_DEVICE static void clear(FixedPointVec* one, FixedPointVec* other, int k) {
    (&one->x)[k] = (&other->x)[k] = 0;
  }
  /// Moves grain s to the end of the substep under its slow force and its contacts. With `exchanges` it transfers
  /// charge in those new contacts in which s is the lower grain.
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
  /// Ends a substep for a grain of another rank, which that rank moves.
  LICHTENBERG_HOST_DEVICE void leave(int s) const {
    grains.busy[s] = 0;
    grains.begun[s] = no_end;
  }
  /// Sets the fixed-point position of grain s for neighbour searches; `position` in d0.
  LICHTENBERG_HOST_DEVICE void locate(int s, Vec3 position) const {
    grains.compact[s].at = fixed_point_position(position, units_per_length);
  }

  /// Ends the contact of candidate pair k after the last substep if the grains have separated. Returns the square of
  /// the relative speed that the elastic energy of the contact can give its grains; 0 without contact.
  LICHTENBERG_HOST_DEVICE double impact2(int k) const {
    const NearPair p = contacts.near[k];
    if (!is_open(p)) return 0;
    const double distance2 = norm2(separation(p));
    if (!continues(k, p, distance2, parameters->begin + parameters->outer)) return 0;
    return 2 * inverse_mass(p) * law.force_terms(reach(p) - root_of(distance2), scale(p)).stored;
  }

  /// Adds the error of the restitution coefficient in the k-th ended contact of the outer step, if it exists, to the
  /// statistics (RestitutionCheck).
  LICHTENBERG_HOST_DEVICE void count_end(int k) const {
    if (k >= results->ended) return;
    const EndedContact contact = restitution.ended[k];
    const GrainPair p{contact.lower, contact.higher};
    restitution.count(law, scale(p), 1 / inverse_mass(p), reach(p), contact);
  }

 protected:
  /// Returns true if this rank owns the row of the pair, so that it counts the pair.
  LICHTENBERG_HOST_DEVICE bool is_own(const NearPair& p) const {
    return !is_divided || range.own.contains(contacts.owner[p.entry]);
  }
  /// Returns true if the pair is in contact. With several ranks the owner of its row decides.
  LICHTENBERG_HOST_DEVICE bool is_open(const NearPair& p) const {
    return is_divided ? contacts.since[p.entry] >= 0 : p.due == NearPair::open;
  }
  /// Lists a new contact of the outer step. `time`: start of the substep (t0).
  LICHTENBERG_HOST_DEVICE void list_onset(double time, int near, double impact_speed) const {
    const int index = parallel::take_index(&results->onsets);
    if (index < contacts.table.end(grains.count - 1))
      contacts.onset[index] = {time, impact_speed, near};
    else
      results->overfull = 1;
  }
  /// Returns true if the separate candidate pair k may come into contact in substep `step`. If not, sets the first
  /// substep in which it may touch.
  LICHTENBERG_HOST_DEVICE bool may_come_into_contact(int k, const NearPair& p, int step) const {
    const double dt = parameters->inner;
    const auto path = static_cast<float>(parameters->reach * dt / parameters->outer);
    const float least = gap(p.lower, p.higher) - static_cast<float>(parameters->max_acceleration * dt * dt);
    return !put_off(k, least, path, step);
  }
  /// Returns true if candidate pair k, with a gap of at least `least`, cannot touch in substep `step`, because a
  /// substep shortens gaps by less than `path`. Then sets the first substep in which it may touch.
  LICHTENBERG_HOST_DEVICE bool put_off(int k, float least, float path, int step) const {
    if (least < path) return false;
    const float steps = least / (path * (1 + 1e-5f));  // the factor covers rounding
    if (steps >= 1) contacts.near[k].due = step + (steps < 1e6f ? static_cast<int>(steps) : 1000000);
    return true;
  }
  /// Returns true if the gap between the surfaces of two grains is less than `gap` (d0), or larger by rounding only.
  LICHTENBERG_HOST_DEVICE bool come_within(int i, int j, float gap) const {
    const CompactGrain a = grains.compact[i], b = grains.compact[j];
    const float most = (a.radius + b.radius + gap) * (1 + 1e-5f);
    return distance2(a, b) < most * most;
  }
  /// Returns a lower bound on the gap between the surfaces of two grains (d0), equal to it except for rounding.
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

  /// Adds `value`, rounded to integers, to the entry in `to` of the grain of the pair with the higher index. Subtracts
  /// it from the entry of the other grain.
  LICHTENBERG_HOST_DEVICE static void add(FixedPointVec* to, const GrainPair& p, Vec3 value) {
    const std::int64_t x = rounded_to_integer(value.x), y = rounded_to_integer(value.y),
                       z = rounded_to_integer(value.z);
    parallel::add_atomically(&to[p.higher].x, x), parallel::add_atomically(&to[p.lower].x, -x);
    parallel::add_atomically(&to[p.higher].y, y), parallel::add_atomically(&to[p.lower].y, -y);
    parallel::add_atomically(&to[p.higher].z, z), parallel::add_atomically(&to[p.lower].z, -z);
  }
  /// Returns the relative acceleration of a pair by slow forces and by the summed contact forces `of`.
  LICHTENBERG_HOST_DEVICE Vec3 relative(const FixedPointVec* of, const GrainPair& p) const {
    const double lower = grains.inverse_mass[p.lower], higher = grains.inverse_mass[p.higher];
    return higher * (grains.slow_force[p.higher] + of[p.higher].times(units.force)) -
           lower * (grains.slow_force[p.lower] + of[p.lower].times(units.force));
  }

  /// Returns true if the contact of candidate pair k continues at this squared distance and time. Otherwise records its
  /// end. Updates the largest overlap, and reports grains whose centres are too close.
  LICHTENBERG_HOST_DEVICE bool continues(int k, const NearPair& p, double distance2, double time) const {
    const double sum = reach(p), distance = root_of(distance2);
    if (grains.touches[p.lower] > 1 || grains.touches[p.higher] > 1) contacts.alone[p.entry] = 0;
    parallel::max_atomically(&extremes->overlap, (sum - distance) / sum);
    if (distance < too_close * sum) parallel::max_atomically(&results->passed, 1 + grains.number[p.lower]);
    if (distance < sum) return true;
    if (contacts.alone[p.entry] && is_own(p)) note_end(p, time);
    contacts.since[p.entry] = -1;
    contacts.near[k].due = 0;
    return false;
  }

  /// Stores the end of a contact of an isolated pair at `time` for RestitutionCheck.
  LICHTENBERG_HOST_DEVICE void note_end(const NearPair& p, double time) const {
    const PairState<3> at = state(p);
    const double began = contacts.since[p.entry];
    restitution.note(
        &results->ended,
        {{began, time - began, contacts.impact_speed[p.entry], -closing(at), speed_across(at)}, p.lower, p.higher});
  }

  /// Returns true if two grains in straight flight come closer than `distance` (d0, between centres) within dt.
  LICHTENBERG_HOST_DEVICE static bool may_touch(double distance, const PairState<3>& at, double dt) {
    const double approach = -dot(at.separation, at.velocity), v2 = norm2(at.velocity);
    const double t = approach <= 0 ? 0 : approach < v2 * dt ? approach / v2 : dt;
    return norm2(at.separation + t * at.velocity) < distance * distance;
  }

  /// Exchanges charge in those new contacts of grain s in which it is the lower grain. Random numbers are those of the
  /// CPU (effects::ChargeExchange), where the count of a contact follows from the ascending order of pairs in a step.
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
  /// Returns the index in the scene of the other grain of a new contact. `end`: element of a grain's linked list of new
  /// contacts, 2 * active pair + (0 for the lower grain, 1 for the higher).
  LICHTENBERG_HOST_DEVICE int partner(int end) const {
    const GrainPair& p = contacts.active[end / 2];
    return grains.number[end % 2 ? p.lower : p.higher];
  }
  /// Transfers charge between the grains of active pair a. `count`: number of earlier collisions of its lower grain.
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
