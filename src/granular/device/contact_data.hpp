#pragma once

// Data of contact substeps in device memory: arrays of grains, candidate pairs, active pairs and contacts, parameters
// and results of outer steps.

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "solvers/neighbours/table.hpp"
#include "src/granular/device/gas_parts.hpp"
#include "src/granular/device/rough_law.hpp"
#include "src/granular/pair_motion.hpp"
#include "src/model/fixed_point_vec.hpp"

namespace lichtenberg::granular::device {

/// Quanta (values of the integer 1) of fixed-point sums over pairs for forces, impulses, shifts (displacement times
/// mass), energies and charges: powers of two, in reduced units.
struct FixedPointScale {
  double force = 1, impulse = 1, shift = 1, energy = 1, charge = 1;

  FixedPointScale inverse() const { return {1 / force, 1 / impulse, 1 / shift, 1 / energy, 1 / charge}; }
};

/// Returns the quantum (m0 v0^2) of fixed-point sums of dissipated energy. It is 2^-32 for up to 32768 grains and then
/// grows with their number. A sum of 32 m0 v0^2 per grain thus fits into 52 bits.
inline double energy_quantum(int grains) {
  return std::ldexp(1.0, -32 + std::max(0, static_cast<int>(std::ceil(std::log2(grains / 32768.0)))));
}

/// Position (fixed-point fractions of the box lengths) and radius (d0) of a grain in 16 bytes, for neighbour searches.
struct alignas(16) CompactGrain {
  FixedPointPosition at;
  float radius = 0;
};

/// Pointers to the arrays of grains in device memory. Grains are sorted by search cells. Reduced units.
struct GrainsView {
  int count = 0;
  Vec3 *position = nullptr, *momentum = nullptr;
  ImageCount* image = nullptr;
  double *charge = nullptr, *inverse_mass = nullptr, *radius = nullptr;
  PointCharge* charged = nullptr;  ///< input of the sums over charges
  int* number = nullptr;           ///< index of the grain in the scene
  CompactGrain* compact = nullptr;
  FixedPointPosition* sorted_at = nullptr;  ///< position at the last sorting
  Vec3* slow_force = nullptr;               ///< smooth forces (all except contacts) at the start of an outer step
  // Sums over the pairs of a grain in a substep, in quanta of FixedPointScale. `force`, `halfway`: contact force at the
  // start and in the middle; `impulse`, `shift`: effect of the contacts over the substep.
  FixedPointVec *force = nullptr, *halfway = nullptr, *impulse = nullptr, *shift = nullptr;
  int* busy = nullptr;                   ///< 1: the grain has an active pair (in contact, or may touch) in this substep
  int* touches = nullptr;                ///< number of contacts in the last substep
  int* begun = nullptr;                  ///< head of the linked list of new contacts; no_end: none
  std::int64_t* collisions = nullptr;    ///< number of onsets, while charge was exchanged
  std::int64_t* moved_charge = nullptr;  ///< quanta to be added to the charge
  std::int64_t* dissipated = nullptr;    ///< energy dissipated in contacts of which the grain is the lower, in quanta

  /// Returns the data of grain i that must be kept when grains are sorted again. `field_at_source`: electric fields at
  /// the grains, or null.
  LICHTENBERG_HOST_DEVICE Grain take(int i, const FieldSample* field_at_source) const {
    return {position[i],     momentum[i], charge[i],
            inverse_mass[i], radius[i],   collisions[i],
            dissipated[i],   charged[i],  field_at_source ? field_at_source[i] : FieldSample{},
            image[i],        number[i]};
  }
  /// Writes the data `g`, as returned by take(), to the grain with the sorted index s.
  LICHTENBERG_HOST_DEVICE void put(int s, const Grain& g, FieldSample* field_at_source) const {
    position[s] = g.position, momentum[s] = g.momentum, charge[s] = g.charge, inverse_mass[s] = g.inverse_mass;
    radius[s] = g.radius, collisions[s] = g.collisions, dissipated[s] = g.dissipated, charged[s] = g.charged;
    if (field_at_source) field_at_source[s] = g.field_at_source;
    image[s] = g.image, number[s] = g.number;
  }
};
/// Marks the end of a linked list of new contacts.
constexpr int no_end = -1;

/// A pair of grains by their sorted indices. The lower grain has the smaller index in the scene.
struct GrainPair {
  int lower = 0, higher = 0;
};
/// A candidate pair of an outer step (from one evaluation of the smooth forces to the next): two grains in contact, or
/// separate grains that may touch in the step.
struct alignas(16) NearPair : GrainPair {
  int entry = 0;  ///< entry of the neighbour table, which has the data of the contact
  int due = 0;    ///< first substep in which the pair may touch; `open`: in contact

  static constexpr int open = -1;
};
/// An active pair of a substep: two grains in contact, or separate grains that may touch in the substep. In linked
/// lists of new contacts, the k-th pair has the elements 2 k (for its lower grain) and 2 k + 1 (for its higher grain).
struct alignas(16) ActivePair : GrainPair {
  int near = 0;      ///< index of the candidate pair
  int touching = 0;  ///< 1: in contact at the start of the substep
};

/// A contact that has begun in an outer step, for transfers of charge that depend on earlier ones
/// (ordered_exchange.hpp). In linked lists of a grain's new contacts, the k-th has the elements 2 k (for its lower
/// grain) and 2 k + 1 (for its higher grain).
struct ContactOnset {
  enum State { waiting, due, done };
  double time = 0, impact_speed = 0;  ///< start of the substep (t0), normal speed at onset (v0)
  int near = 0;                       ///< index of the candidate pair
  int next[2] = {no_end, no_end};
  int state = waiting;
};

/// Pointers to the arrays of candidate pairs, active pairs and contacts in device memory. Reduced units.
struct ContactsView {
  TableView table;                                   ///< neighbour table with each pair once
  int* owner = nullptr;                              ///< [entries], grain of the row
  double *since = nullptr, *impact_speed = nullptr;  ///< [entries]; since: time of onset, negative or NaN: no contact
  int* alone = nullptr;                              ///< [entries], 1: no third grain has been in contact since onset

  NearPair* near = nullptr;
  ActivePair* active = nullptr;
  PairState<3>* state = nullptr;  ///< state of an active pair at the start of a substep
  double* scale = nullptr;        ///< factor of the contact law for the radii of an active pair
  /// Contact force on the higher grain of an active pair at the start and in the middle of a substep. first: relative
  /// acceleration by all other forces at the start.
  Vec3 *force = nullptr, *halfway = nullptr, *first = nullptr;
  int* next = nullptr;            ///< [2 * entries], next element in the linked list of a grain's new contacts
  ContactOnset* onset = nullptr;  ///< [entries], new contacts of the outer step; null: not needed
  Vec3* spring = nullptr;  ///< [entries], elongation of the tangential spring; null for smooth grains, as `rough`
  RoughContactState* rough = nullptr;
};

/// Results of outer steps (from one evaluation of the smooth forces to the next), from which the next step is chosen,
/// and errors, for the host. Reduced units.
struct StepResults {
  std::int64_t begun = 0, transfers = 0;  ///< numbers of contact onsets and charge transfers in the step
  /// Numbers of transfers that the capacity has refused, and of those that have not changed a charge.
  std::int64_t refused = 0, unchanged = 0;
  double speed2 = 0;         ///< square of the largest speed
  double acceleration2 = 0;  ///< square of the largest acceleration by smooth forces
  /// Square of the largest relative speed that the elastic energy of a contact can give its grains.
  double impact2 = 0;
  double moved2 = 0;                     ///< square of the largest displacement since the last sorting
  double too_fast2 = 0;                  ///< square of the largest speed of rough grains above the assumed bound
  double charge = 0;                     ///< largest magnitude of a charge
  int lost = 0;                          ///< not 0: a position or velocity is not finite
  int pairs = 0, active = 0, ended = 0;  ///< numbers of candidate pairs, active pairs and ended isolated contacts
  int passed = 0;                        ///< 1 + number of a grain through which another has passed; 0: none
  int escaped = 0;                       ///< 1 + number of a grain that has passed through a wall; 0: none
  int onsets = 0, overfull = 0;          ///< number of listed onsets; not 0: the list has been too short
  /// 1 + index of a side that a charge has crossed, and 1 if the mesh no longer fits an unbounded cloud; otherwise 0.
  int crossed = 0, outgrown = 0;

  /// Adds the results of another rank for its grains and pairs.
  LICHTENBERG_HOST_DEVICE void join(const StepResults& o) {
    begun += o.begun, transfers += o.transfers, refused += o.refused, unchanged += o.unchanged;
    const auto raise = [](auto& most, auto value) { most = value > most ? value : most; };
    raise(speed2, o.speed2), raise(acceleration2, o.acceleration2), raise(impact2, o.impact2);
    raise(moved2, o.moved2), raise(too_fast2, o.too_fast2), raise(charge, o.charge);
    raise(lost, o.lost), raise(passed, o.passed), raise(escaped, o.escaped);
    raise(overfull, o.overfull), raise(crossed, o.crossed), raise(outgrown, o.outgrown);
  }
  /// Resets the results that accumulate in a step: the counts and `impact2`.
  LICHTENBERG_HOST_DEVICE void begin_step() {
    begun = transfers = refused = unchanged = 0;
    impact2 = too_fast2 = 0;
    pairs = active = ended = onsets = 0;
  }
};
/// Maxima over all steps since the start of the run.
struct Extremes {
  double overlap = 0;  ///< largest ratio of overlap to sum of radii
};

/// Parameters of an outer step (from one evaluation of the smooth forces to the next) on a device, in reduced units.
struct StepParameters {
  double begin = 0;             ///< start of the outer step (t0)
  double outer = 0;             ///< length of the outer step (t0)
  double inner = 0;             ///< length of a contact substep (t0)
  double reach = 0;             ///< largest gap of candidate pairs (d0)
  double max_acceleration = 0;  ///< bound on relative accelerations of two grains
  int steps = 0;                ///< number of contact substeps
  int unused = 0;
};

}  // namespace lichtenberg::granular::device
