#pragma once

// Contact substeps of rough grains (../rough_steps.hpp) on an executor. A substep has two phases: move() for each
// grain, which completes the last substep and begins the next one, and follow_pair() and follow_walls() for contacts.
// Sums over the contacts of a grain are integers, so results do not depend on the order of lists and threads.

#include <cmath>
#include <cstdint>

#include "src/granular/device/contact_steps.hpp"
#include "src/granular/device/rough_law.hpp"
#include "src/granular/rough_substep.hpp"

namespace lichtenberg::granular::device {

/// Pointers to the arrays of rough grains in device memory, in the order of the sorted grains unless stated otherwise.
/// Reduced units.
struct RoughView {
  Vec3* spin = nullptr;          ///< angular velocity; in the middle of a substep while contacts are followed
  double* inertia = nullptr;     ///< moment of inertia; 0: the grains do not rotate
  unsigned* at_walls = nullptr;  ///< bit k: in contact with wall k
  Vec3 *predicted_velocity = nullptr, *predicted_spin = nullptr;  ///< for the end of a substep
  /// Sums over the contacts of a grain in a substep: torque in quanta `torque_unit`, corrections of the angular
  /// momentum at the ends of contacts in quanta `angular_unit`.
  FixedPointVec *torque = nullptr, *angular_impulse = nullptr;
  int* touched = nullptr;                   ///< number of contacts in the last substep
  const GrainMaterial* material = nullptr;  ///< by number in the scene; null: all have the scene's material
  RoughSides walls;
  // Contacts with walls, [N * walls.count()]: wall k of grain `number` has the index number * walls.count() + k.
  double *wall_since = nullptr, *wall_speed = nullptr;  ///< onset, impact speed
  Vec3* wall_spring = nullptr;
  RoughContactState* wall_state = nullptr;
  double torque_unit = 1, angular_unit = 1;
};

/// Contact substeps of rough grains in an outer step (from one evaluation of the smooth forces to the next) on a
/// device. Kernels call its functions for single grains and pairs. Reduced units.
template <class Law>
struct RoughContactSteps : ContactSteps<RoughLaw<Law>> {
  using Smooth = ContactSteps<RoughLaw<Law>>;
  using Smooth::contacts, Smooth::exchanges, Smooth::extremes, Smooth::grains, Smooth::inverse_units, Smooth::law,
      Smooth::parameters, Smooth::restitution, Smooth::results, Smooth::units, Smooth::units_per_length;

  RoughView rough;

  /// Returns the assumed bound on the speeds of grains in the outer step.
  LICHTENBERG_HOST_DEVICE double bound_on_speeds() const { return parameters->reach / (2 * parameters->outer); }
  /// Returns true if the pair of entry e of the neighbour table is in contact, or its gap (d0) is below `reach`.
  LICHTENBERG_HOST_DEVICE bool is_near(int e, float reach) const {
    return contacts.since[e] >= 0 || this->come_within(contacts.owner[e], contacts.table.partner[e], reach);
  }

  /// Computes the forces of candidate pair k, if it is in contact, at the start of the outer step.
  LICHTENBERG_HOST_DEVICE void begin_pair(int k) const {
    const NearPair p = contacts.near[k];
    if (p.due != NearPair::open) return;
    const Vec3 r = this->separation(p);
    const double distance = norm(r);
    if (passes(p, distance)) return;
    const SurfaceGeometry geometry = geometry_of(p, r, distance);
    RoughContactState& state = contacts.rough[p.entry];
    begin_forces(law.surface.grains, constants(p), pair_motion(p, geometry, false), contacts.spring[p.entry], state);
    add_forces(p, load_of(geometry, state.now));
  }
  /// Computes the forces of the walls on grain s at the start of the outer step.
  LICHTENBERG_HOST_DEVICE void begin_walls(int s) const {
    for (int k = 0; k < rough.walls.count(); ++k) {
      if (!(rough.at_walls[s] >> k & 1)) continue;
      const SurfaceGeometry geometry = geometry_at(s, k);
      RoughContactState& state = rough.wall_state[wall_index(s, k)];
      begin_forces(law.surface.walls, constants_at_wall(s), surface_motion(geometry, motion(s, false), {}, substep()),
                   rough.wall_spring[wall_index(s, k)], state);
      add_forces(s, load_of(geometry, state.now));
    }
  }

  /// Completes substep `step` - 1 of grain s, except for `step` = 0, with the forces at its end. Begins substep `step`,
  /// except after the last one: moves the grain, and predicts its velocities.
  LICHTENBERG_HOST_DEVICE void move(int s, int step) const {
    const double h = substep(), over = grains.inverse_mass[s], inertia = rough.inertia[s];
    const double spin_over = inertia > 0 ? 1 / inertia : 0;
    Vec3 p = grains.momentum[s], w = rough.spin[s], force = grains.slow_force[s], torque;
    const bool busy = grains.busy[s];
    if (busy) force += grains.force[s].times(units.force), torque = rough.torque[s].times(rough.torque_unit);
    const Vec3 kick = 0.5 * h * force, turn = (0.5 * h * spin_over) * torque;
    if (step > 0) {
      p += kick, w += turn;
      if (busy) p += grains.impulse[s].times(units.impulse), w += spin_over * angular_impulse(s);
      const double most = bound_on_speeds(), speed2 = norm2(over * p);
      if (speed2 > most * most) parallel::max_atomically(&results->too_fast2, speed2);
      if (busy && exchanges && grains.begun[s] != no_end) this->begin_contacts(s);
    }
    if (busy) clear_sums(s);
    rough.touched[s] = grains.touches[s];
    grains.touches[s] = 0;
    if (step < parameters->steps) {
      p += kick, w += turn;
      const Vec3 position = grains.position[s] + h * over * p;
      grains.position[s] = position;
      this->locate(s, position);
      rough.predicted_velocity[s] = over * (p + kick), rough.predicted_spin[s] = w + turn;
    }
    grains.momentum[s] = p, rough.spin[s] = w;
  }

  /// Computes the forces of candidate pair k at the end of substep `step`. Its contact may begin or end in it. `path`:
  /// largest change of a gap in a substep (d0).
  LICHTENBERG_HOST_DEVICE void follow_pair(int k, int step, float path) const {
    const NearPair p = contacts.near[k];
    const bool open = p.due == NearPair::open;
    if (!open && this->put_off(k, this->gap(p.lower, p.higher), path, step)) return;
    const Vec3 r = this->separation(p);
    const double distance = norm(r);
    if (!open && !(distance < this->reach(p))) return;
    if (passes(p, distance)) return;
    const SurfaceGeometry geometry = geometry_of(p, r, distance);
    const SurfaceMotion half = pair_motion(p, geometry, false);
    RoughContactState& state = contacts.rough[p.entry];
    const Made made = advance({law.surface.grains, constants(p), half, pair_motion(p, geometry, true)}, !open,
                              contacts.spring[p.entry], state);
    if (made.part) add_impulses(p, load_of(geometry, made.impulse));
    const bool others = rough.touched[p.lower] > open || rough.touched[p.higher] > open;
    if (!open) begin(k, p, half.closing, step, made.share);
    if (others) contacts.alone[p.entry] = 0;
    if (made.ended) {
      if (contacts.alone[p.entry]) note_end(p, half, made, parameters->begin + (step + made.share) * substep());
      contacts.since[p.entry] = -1;
      contacts.near[k].due = step + 1;
    } else {
      add_forces(p, load_of(geometry, state.now));
      parallel::max_atomically(&extremes->overlap, geometry.overlap / this->reach(p));
    }
    note_dissipated(p.lower, step, made.ended, state);
  }
  /// Computes the forces of the walls on grain s at the end of substep `step`.
  LICHTENBERG_HOST_DEVICE void follow_walls(int s, int step) const {
    for (int k = 0; k < rough.walls.count(); ++k) follow_wall(s, k, step);
  }

  /// Returns the square of the relative speed that the stored energy of the contact of candidate pair k can give its
  /// grains; 0 without contact. Marks contacts that a third grain has joined in the last substep.
  LICHTENBERG_HOST_DEVICE double impact2(int k) const {
    const NearPair p = contacts.near[k];
    if (p.due != NearPair::open) return 0;
    if (rough.touched[p.lower] > 1 || rough.touched[p.higher] > 1) contacts.alone[p.entry] = 0;
    const double stored =
        law.surface.grains.energy(constants(p), this->reach(p) - norm(this->separation(p)), contacts.spring[p.entry]);
    return stored > 0 ? 2 * this->inverse_mass(p) * stored : 0;
  }
  /// Updates the largest impact2() by the contacts of grain s with walls.
  LICHTENBERG_HOST_DEVICE void find_wall_impacts(int s) const {
    for (int k = 0; k < rough.walls.count(); ++k) {
      if (!(rough.at_walls[s] >> k & 1)) continue;
      const double stored = law.surface.walls.energy(constants_at_wall(s), geometry_at(s, k).overlap,
                                                     rough.wall_spring[wall_index(s, k)]);
      parallel::max_atomically(&results->impact2, 2 * grains.inverse_mass[s] * stored);
    }
  }

 private:
  /// Result of a substep of a contact. `part`: it acted during a part of the substep, with `impulse` in addition.
  struct Made {
    bool part = false, ended = false;
    double share = 1;
    SurfaceForces impulse{};
  };

  /// A contact and the motion of its surfaces in a substep (RoughSubstep).
  struct MovingContact {
    const RoughContactLaw<Law>& law;
    RoughPair constants;
    SurfaceMotion half, end;
  };

  LICHTENBERG_HOST_DEVICE double substep() const { return parameters->inner; }
  LICHTENBERG_HOST_DEVICE RigidMotion motion(int s, bool predicted) const {
    if (predicted) return {rough.predicted_velocity[s], rough.predicted_spin[s]};
    return {grains.inverse_mass[s] * grains.momentum[s], rough.spin[s]};
  }
  LICHTENBERG_HOST_DEVICE SurfaceMotion pair_motion(const GrainPair& p, const SurfaceGeometry& geometry,
                                                    bool predicted) const {
    return surface_motion(geometry, motion(p.lower, predicted), motion(p.higher, predicted), substep());
  }
  LICHTENBERG_HOST_DEVICE SurfaceGeometry geometry_of(const GrainPair& p, Vec3 separation, double distance) const {
    return geometry_of_pair(separation, distance, grains.radius[p.lower], grains.radius[p.higher]);
  }
  LICHTENBERG_HOST_DEVICE SurfaceGeometry geometry_at(int s, int k) const {
    const int side = rough.walls.side(k);
    const double radius = grains.radius[s];
    return geometry_at_side(side, rough.walls.gap(grains.position[s], radius, side), radius);
  }
  LICHTENBERG_HOST_DEVICE long wall_index(int s, int k) const {
    return static_cast<long>(grains.number[s]) * rough.walls.count() + k;
  }
  LICHTENBERG_HOST_DEVICE RoughPair constants(const GrainPair& p) const {
    RoughPair of = law.surface.between(grains.radius[p.lower], grains.radius[p.higher], rough.inertia[p.lower],
                                       rough.inertia[p.higher]);
    if (rough.material)
      law.surface.set_materials(rough.material[grains.number[p.lower]], rough.material[grains.number[p.higher]], of);
    return of;
  }
  LICHTENBERG_HOST_DEVICE RoughPair constants_at_wall(int s) const {
    RoughPair of = law.surface.at_wall(grains.radius[s], rough.inertia[s]);
    if (rough.material) law.surface.set_materials(rough.material[grains.number[s]], GrainMaterial{}, of);
    return of;
  }
  /// Returns true, and reports an error, if the centres of a pair are too close for a contact.
  LICHTENBERG_HOST_DEVICE bool passes(const GrainPair& p, double distance) const {
    if (!(distance < too_close * this->reach(p))) return false;
    parallel::max_atomically(&results->passed, 1 + grains.number[p.lower]);
    return true;
  }

  /// Computes the forces of a contact at the first instant of an outer step, without a change of its spring.
  LICHTENBERG_HOST_DEVICE static void begin_forces(const RoughContactLaw<Law>& by, const RoughPair& of,
                                                   const SurfaceMotion& now, Vec3 elongation,
                                                   RoughContactState& state) {
    TangentialSpring spring{elongation, 0};
    state.now = by.forces(of, now, {}, spring);
    state.stiffness = spring.stiffness, state.overlap = now.overlap, state.dissipated = 0;
  }
  /// Advances a contact by a substep. `fresh`: it begins in the substep.
  LICHTENBERG_HOST_DEVICE Made advance(const MovingContact& contact, bool fresh, Vec3& elongation,
                                       RoughContactState& state) const {
    const auto& [by, of, half, end] = contact;
    if (fresh) elongation = {}, state = {};
    const RoughSubstep<Law> step{by, of, substep()};
    TangentialSpring spring{elongation, state.stiffness};
    const double last = by.last_overlap(of);
    Made made;
    made.ended = !fresh && half.overlap <= last, made.part = fresh || made.ended;
    if (made.part) {
      const auto part =
          fresh ? step.begin(half, end, spring, state.now) : step.end(half, state.overlap, last, spring, state.now);
      made.share = part.share, made.impulse = part.impulse;
      state.dissipated += part.dissipated;
    } else {
      state.dissipated += step.proceed(half, end, spring, state.now);
    }
    elongation = spring.elongation, state.stiffness = spring.stiffness, state.overlap = half.overlap;
    return made;
  }
  LICHTENBERG_HOST_DEVICE void follow_wall(int s, int k, int step) const {
    const bool open = rough.at_walls[s] >> k & 1;
    const SurfaceGeometry geometry = geometry_at(s, k);
    if (!open && !(geometry.overlap > 0)) return;
    if (geometry.overlap > (1 - too_close) * grains.radius[s])
      parallel::max_atomically(&results->escaped, 1 + grains.number[s]);
    const SurfaceMotion half = surface_motion(geometry, motion(s, false), {}, substep());
    const long index = wall_index(s, k);
    RoughContactState& state = rough.wall_state[index];
    const SurfaceMotion end = surface_motion(geometry, motion(s, true), {}, substep());
    const Made made =
        advance({law.surface.walls, constants_at_wall(s), half, end}, !open, rough.wall_spring[index], state);
    if (made.part) add_impulses(s, load_of(geometry, made.impulse));
    if (!open) {
      rough.at_walls[s] |= 1u << k;
      rough.wall_since[index] = parameters->begin + (step + 1 - made.share) * substep();
      rough.wall_speed[index] = half.closing > 0 ? half.closing : 0;
    }
    if (made.ended) {
      rough.at_walls[s] &= ~(1u << k);
    } else {
      add_forces(s, load_of(geometry, state.now));
      parallel::max_atomically(&extremes->overlap, geometry.overlap / (2 * grains.radius[s]));
    }
    note_dissipated(s, step, made.ended, state);
  }
  /// Records the onset of the contact of candidate pair k in the last part of substep `step`, which is `share` of it.
  LICHTENBERG_HOST_DEVICE void begin(int k, const NearPair& p, double closing, int step, double share) const {
    contacts.near[k].due = NearPair::open;
    contacts.since[p.entry] = parameters->begin + (step + 1 - share) * substep();
    contacts.impact_speed[p.entry] = closing > 0 ? closing : 0;
    contacts.alone[p.entry] = law.plain;
    parallel::add_atomically(&results->begun, std::int64_t{1});
    if (contacts.onset) this->list_onset(parameters->begin + step * substep(), k, contacts.impact_speed[p.entry]);
    if (!exchanges) return;
    contacts.active[k] = {{p.lower, p.higher}, k, 0};
    contacts.next[2 * k] = parallel::exchange_atomically(&grains.begun[p.lower], 2 * k);
    contacts.next[2 * k + 1] = parallel::exchange_atomically(&grains.begun[p.higher], 2 * k + 1);
  }
  /// Stores the end of a contact of an isolated pair at `time` for RestitutionCheck.
  LICHTENBERG_HOST_DEVICE void note_end(const NearPair& p, const SurfaceMotion& half, const Made& made,
                                        double time) const {
    const double began = contacts.since[p.entry];
    const double release = made.impulse.normal.force * this->inverse_mass(p) - half.closing;
    const Vec3 v = motion(p.lower, false).velocity - motion(p.higher, false).velocity;
    restitution.note(&results->ended, {{began, time - began, contacts.impact_speed[p.entry], release,
                                        norm(v - half.closing * half.normal)},
                                       p.lower,
                                       p.higher});
  }
  /// Adds the energy that a contact has dissipated in the outer step to the sum of grain s, at its end or at that of
  /// the step.
  LICHTENBERG_HOST_DEVICE void note_dissipated(int s, int step, bool ended, RoughContactState& state) const {
    if (!ended && step + 1 < parameters->steps) return;
    parallel::add_atomically(&grains.dissipated[s], rounded_to_integer(inverse_units.energy * state.dissipated));
    state.dissipated = 0;
  }

  LICHTENBERG_HOST_DEVICE Vec3 angular_impulse(int s) const {
    return rough.angular_impulse[s].times(rough.angular_unit);
  }
  LICHTENBERG_HOST_DEVICE void clear_sums(int s) const {
    grains.force[s] = grains.impulse[s] = rough.torque[s] = rough.angular_impulse[s] = {};
    grains.busy[s] = 0;
  }
  LICHTENBERG_HOST_DEVICE static void add(FixedPointVec& to, Vec3 value) {
    parallel::add_atomically(&to.x, rounded_to_integer(value.x));
    parallel::add_atomically(&to.y, rounded_to_integer(value.y));
    parallel::add_atomically(&to.z, rounded_to_integer(value.z));
  }
  /// Adds the forces of a contact of grain s with a wall, and counts the contact.
  LICHTENBERG_HOST_DEVICE void add_forces(int s, const SurfaceLoad& load) const {
    grains.busy[s] = 1;
    parallel::add_atomically(&grains.touches[s], 1);
    add(grains.force[s], inverse_units.force * load.force);
    add(rough.torque[s], (1 / rough.torque_unit) * load.torque);
  }
  LICHTENBERG_HOST_DEVICE void add_impulses(int s, const SurfaceLoad& load) const {
    grains.busy[s] = 1;
    add(grains.impulse[s], inverse_units.impulse * load.force);
    add(rough.angular_impulse[s], (1 / rough.angular_unit) * load.torque);
  }
  /// Adds the forces of a contact of two grains, and counts the contact.
  LICHTENBERG_HOST_DEVICE void add_forces(const GrainPair& p, const SurfaceLoad& load) const {
    add_forces(p.lower, load);
    add_forces(p.higher, {-load.force, load.other_torque, {}});
  }
  LICHTENBERG_HOST_DEVICE void add_impulses(const GrainPair& p, const SurfaceLoad& load) const {
    add_impulses(p.lower, load);
    add_impulses(p.higher, {-load.force, load.other_torque, {}});
  }
};

}  // namespace lichtenberg::granular::device
