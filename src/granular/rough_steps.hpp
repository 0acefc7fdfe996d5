#pragma once

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "solvers/neighbours/cell_order.hpp"
#include "src/granular/active_grains.hpp"
#include "src/granular/contact_motion.hpp"
#include "src/granular/contact_schedule.hpp"
#include "src/granular/contacts.hpp"
#include "src/granular/rough_laws.hpp"
#include "src/granular/rough_substep.hpp"

namespace lichtenberg::granular {

/// Substeps with one search for pairs that may touch.
struct RoughChunk {
  double begin = 0, h = 0;             ///< start and substep (t0)
  int steps = 1;                       ///< largest number of substeps
  double speed = 0;                    ///< v0: somewhat above the largest speed at the start, with slow forces
  double gain = 0;                     ///< v0: bound on the velocity change by slow forces
  std::span<const double> slow_force;  ///< constant forces, [N * d] or empty

  double time() const { return steps * h; }
  /// Returns the largest velocity (v0) that contacts may give a grain; the substeps end early if they give more. In a
  /// long chunk a collision gives up to `speed`. In a few substeps it gives a part of it only, because contacts last
  /// many substeps. Contacts at rest cancel the slow forces.
  double most_gain() const { return std::min(1.0, 0.15 * steps) * speed + gain; }
};

/// Velocity Verlet substeps of rough grains. Forces at the end of a substep depend on velocities, which are predicted
/// with the forces at its start. In a substep in which a contact begins or ends, its force acts during the part of the
/// substep that the overlap gives. Jumps of the force (adhesion, dashpots) then cause errors of second order. A contact
/// that begins and ends in one substep is not found.
template <int d, class Law>
class RoughSteps {
 public:
  /// Both must outlive the object.
  RoughSteps(const RoughLaws<Law>& laws, const RoughSides& sides) : laws_(laws), sides_(sides) {}

  /// Returns the box of the bodies, without periods along z in two dimensions.
  static Box<3> box_of(const Bodies& bodies) {
    Box<3> box = bodies.box;
    if (d == 2) box.sides[4] = box.sides[5] = Boundary::wall;
    return box;
  }

  /// Advances the bodies by at most `chunk.steps` substeps. `open`: open contacts in ascending order of pairs. Adds
  /// events, dissipated energy and work to `followed`. Returns the number of substeps.
  int advance(Bodies& bodies, std::vector<RoughOpen>& open, const RoughChunk& chunk, ContactsFollowed& followed,
              parallel::Team& team) {
    bodies_ = &bodies, nearest_ = NearestImage<3>(box_of(bodies));
    chunk_ = &chunk, followed_ = &followed;
    h_ = chunk.h;
    widest_ = *std::ranges::max_element(bodies.radius);
    constexpr double margin = 1.2;  // for the half substep before most_gain() is tested
    approach_ = 2 * margin * chunk.most_gain();
    cells_.sort(spheres<d>(bodies), 2 * widest_ + (2 * chunk.speed + approach_) * chunk.time());
    grains_.begin(bodies, chunk.slow_force, h_, cells_.particles(), cells_.slots());
    activations_.begin(chunk.steps), tests_.begin(chunk.steps);
    for (RoughOpen& one : open) bind(one, 0);
    predict(team);
    for (RoughOpen& one : open) evaluate_first(one);
    int done = 0;
    for (bool valid = true; valid && done < chunk.steps; ++done) valid = substep(open, done);
    followed.work += grains_.finish(bodies, done);
    return done;
  }

 private:
  /// Pairs of grains in the schedules are pairs of slots.
  Vec3 separation(Pair slots, int n) const {
    return nearest(grains_.position(slots.j, n) - grains_.position(slots.i, n));
  }
  double reach_of(Pair slots) const { return grains_.flight(slots.i).radius + grains_.flight(slots.j).radius; }
  Pair grains_of(Pair slots) const {
    const int i = grains_.grain_in(slots.i), j = grains_.grain_in(slots.j);
    return {std::min(i, j), std::max(i, j)};
  }
  Vec3 nearest(Vec3 r) const {
    for (int k = 0; k < 3; ++k) r[k] = nearest_(r[k], k);
    return r;
  }

  /// Makes a grain active at the instant n. Returns its index.
  int activate(int slot, int n) {
    const int index = grains_.index_of(slot);
    return index >= 0 ? index : grains_.activate(slot, n);
  }
  /// Schedules the next test of a pair at the instant n, unless it cannot touch any more. `r`: separation. Free flight
  /// closes a gap fastest at first, because the distance is then a convex function of time; contacts add `approach_`.
  void schedule(Pair slots, Vec3 r, double distance, int n) {
    const ActiveGrains::Flight &a = grains_.flight(slots.i), &b = grains_.flight(slots.j);
    const Vec3 slow = b.acceleration - a.acceleration, v = b.velocity - a.velocity + n * h_ * slow;
    const double closing = approach_ + chunk_->time() * norm(slow) - dot(r, v) / distance;
    const double gap = std::max(0.0, distance - (a.radius + b.radius)), left = (chunk_->steps - n) * h_;
    if (gap > 0 && gap > closing * left) return;
    tests_.add(n + std::max(1.0, std::floor(gap / (closing * h_))), slots);
  }
  /// Makes the grains of a contact active at the instant n.
  void bind(RoughOpen& one, int n) {
    const auto [i, j] = one.contact.pair;
    one.i = activate(grains_.slot_of(i), n), one.j = j < bodies_->size() ? activate(grains_.slot_of(j), n) : -1;
    ++grains_.active()[one.i].contacts;
    if (one.j >= 0) ++grains_.active()[one.j].contacts;
  }

  /// Finds the pairs that may touch and schedules their tests. Schedules the activation of free grains that come into
  /// contact.
  void predict(parallel::Team& team) {
    const double longest = chunk_->time();
    double squares = 0;  // the largest square of an acceleration
    for (int s = 0; s < cells_.size(); ++s) {
      const auto& [x, v, a, radius] = grains_.flight(s);
      Vec<d> velocity;
      for (int k = 0; k < d; ++k) velocity[k] = v[k];
      cells_.set_velocity(s, velocity);
      squares = std::max(squares, norm2(a));
      if (sides_.any()) predict_at_sides(s, longest);
    }
    const double reach = (1 + 1e-9) * 2 * widest_, more = longest * (approach_ + longest * std::sqrt(squares));
    for (const Pair slots : cells_.pairs_that_meet({.time = longest, .within = reach + more, .near = reach}, team)) {
      const auto [i, j] = slots;
      const ActiveGrains::Flight &a = grains_.flight(i), &b = grains_.flight(j);
      const Vec3 r = nearest(b.position - a.position);
      schedule(slots, r, norm(r), 0);
      if (grains_.index_of(i) >= 0 || grains_.index_of(j) >= 0) continue;
      const RelativeFlight relative{r, b.velocity - a.velocity, b.acceleration - a.acceleration};
      const double time = earliest_contact(relative, a.radius + b.radius, longest);
      if (time < longest) activations_.add(std::floor(time / h_), slots);
    }
  }
  void predict_at_sides(int slot, double longest) {
    const auto& [x, v, a, radius] = grains_.flight(slot);
    const double travel = longest * (norm(v) + 0.5 * longest * norm(a));
    sides_.visit(x, radius, [&](int, double gap) {
      if (gap < travel) activations_.add(0, {slot, slot});
    });
  }

  /// Advances the active grains by substep n. Returns false if contacts have given a grain more than most_gain().
  bool substep(std::vector<RoughOpen>& open, int n) {
    // The result must not depend on the order of cells.
    std::ranges::sort(activations_.due(n), {}, [&](Pair slots) { return grains_of(slots); });
    for (const auto [i, j] : activations_.due(n))
      if (grains_.index_of(i) < 0 && grains_.index_of(j) < 0) activate(i, n), activate(j, n);
    for (ActiveGrain& one : grains_.active()) {
      kick(one);
      one.position += h_ * one.velocity;
    }
    find_contacts(open, n);
    for (ActiveGrain& one : grains_.active()) {
      one.predicted_velocity = one.velocity + 0.5 * h_ * (one.per_mass * one.force + one.slow);
      one.predicted_spin = one.spin + (0.5 * h_ * one.per_inertia) * one.torque;
      one.force = one.torque = one.impulse = one.angular_impulse = {};
    }
    for (RoughOpen& one : open) evaluate(one, n);
    std::erase_if(open, [](const RoughOpen& one) { return !one.open; });
    double gain = 0;
    for (ActiveGrain& one : grains_.active()) {
      kick(one);
      one.velocity += one.per_mass * one.impulse;
      one.spin += one.per_inertia * one.angular_impulse;
      gain = std::max(gain, norm2(one.velocity - one.start - (n + 1) * h_ * one.slow));
    }
    return gain <= chunk_->most_gain() * chunk_->most_gain();
  }
  /// Applies forces and torques for half a substep.
  void kick(ActiveGrain& one) const {
    one.velocity += 0.5 * h_ * (one.per_mass * one.force + one.slow);
    one.spin += (0.5 * h_ * one.per_inertia) * one.torque;
  }

  /// Adds the contacts that have begun in substep n to the open ones.
  void find_contacts(std::vector<RoughOpen>& open, int n) {
    begun_.clear();
    for (const Pair slots : tests_.due(n + 1)) {
      const Vec3 r = separation(slots, n + 1);
      const double distance = norm(r);
      distance < reach_of(slots) ? begin_contact(open, grains_of(slots), n) : schedule(slots, r, distance, n + 1);
    }
    for (std::size_t k = 0; sides_.any() && k < grains_.active().size(); ++k) {
      const ActiveGrain one = grains_.active()[k];
      sides_.visit(one.position, one.radius, [&](int side, double gap) {
        if (gap < 0) begin_contact(open, {one.grain, bodies_->size() + side}, n);
      });
    }
    if (begun_.empty()) return;
    std::ranges::sort(begun_, {}, pair_of);
    const auto old = static_cast<std::ptrdiff_t>(open.size());
    open.insert(open.end(), begun_.begin(), begun_.end());
    std::ranges::inplace_merge(open, open.begin() + old, {}, pair_of);
  }
  static Pair pair_of(const RoughOpen& one) { return one.contact.pair; }

  void begin_contact(std::span<const RoughOpen> open, Pair pair, int n) {
    if (std::ranges::binary_search(open, pair, {}, pair_of) || std::ranges::find(begun_, pair, pair_of) != begun_.end())
      return;
    RoughOpen one = laws_.opened(*bodies_, {.pair = pair});
    one.fresh = true;
    for (const int grain : {pair.i, pair.j})
      if (grain < bodies_->size() && grains_.index_of(grains_.slot_of(grain)) < 0) {
        ActiveGrain& active = grains_.active()[activate(grains_.slot_of(grain), n + 1)];
        active.velocity -= 0.5 * h_ * active.slow;  // the second half of this substep follows
      }
    bind(one, n + 1);
    begun_.push_back(one);
  }

  SurfaceGeometry geometry_of(const RoughOpen& one) const {
    const ActiveGrain& a = grains_.active()[one.i];
    if (one.j < 0) {
      const int side = one.contact.pair.j - bodies_->size();
      const double gap = sides_.gap(a.position, a.radius, side);
      if (a.radius + gap < too_close * a.radius) refuse_flight_through_wall(one.contact.pair.i, side);
      return geometry_at_side(side, gap, a.radius);
    }
    const ActiveGrain& b = grains_.active()[one.j];
    const Vec3 r = nearest(b.position - a.position);
    const double distance = norm(r);
    if (distance < too_close * (a.radius + b.radius)) refuse_flight_through(one.contact);
    return geometry_of_pair(r, distance, a.radius, b.radius);
  }
  /// Returns the relative motion of the surfaces, with the velocities in the middle of the substep or with those
  /// predicted for its end.
  SurfaceMotion motion_of(const RoughOpen& one, const SurfaceGeometry& geometry, bool predicted) const {
    const auto of = [&](int k) -> RigidMotion {
      if (k < 0) return {};
      const ActiveGrain& grain = grains_.active()[k];
      return predicted ? RigidMotion{grain.predicted_velocity, grain.predicted_spin}
                       : RigidMotion{grain.velocity, grain.spin};
    };
    return surface_motion(geometry, of(one.i), of(one.j), h_);
  }
  RoughSubstep<Law> substep_of(const RoughOpen& one) const {
    return {laws_.of(*bodies_, one.contact.pair), one.constants, h_};
  }

  /// Computes the forces of an open contact at the first instant, without a change of its spring.
  void evaluate_first(RoughOpen& one) {
    const SurfaceGeometry geometry = geometry_of(one);
    TangentialSpring spring{one.spring.elongation, 0};
    one.now = laws_.of(*bodies_, one.contact.pair).forces(one.constants, motion_of(one, geometry, false), {}, spring);
    one.spring.stiffness = spring.stiffness, one.overlap = geometry.overlap;
    add(one, geometry, one.now, &ActiveGrain::force, &ActiveGrain::torque);
  }

  /// Computes the forces of a contact at the end of substep n.
  void evaluate(RoughOpen& one, int n) {
    const SurfaceGeometry geometry = geometry_of(one);
    const SurfaceMotion half = motion_of(one, geometry, false);
    if (geometry.overlap <= one.last_overlap && !one.fresh) return end(one, geometry, half, n);
    const ActiveGrain& a = grains_.active()[one.i];
    if (a.contacts > 1 || (one.j >= 0 && grains_.active()[one.j].contacts > 1)) one.contact.alone = false;
    one.fresh ? begin(one, geometry, half, n) : proceed(one, geometry, half);
    one.overlap = geometry.overlap, one.fresh = false;
    followed_->record.largest_overlap =
        std::max(followed_->record.largest_overlap,
                 geometry.overlap / (one.j < 0 ? 2 * a.radius : reach(*bodies_, one.contact.pair)));
  }

  /// Computes the forces at the end of a substep during which the contact lasts.
  void proceed(RoughOpen& one, const SurfaceGeometry& geometry, const SurfaceMotion& half) {
    followed_->record.dissipated += substep_of(one).proceed(half, motion_of(one, geometry, true), one.spring, one.now);
    add(one, geometry, one.now, &ActiveGrain::force, &ActiveGrain::torque);
  }

  /// Computes the forces at the end of the substep in which the contact has begun. They act during a part of it.
  void begin(RoughOpen& one, const SurfaceGeometry& geometry, const SurfaceMotion& half, int n) {
    const auto made = substep_of(one).begin(half, motion_of(one, geometry, true), one.spring, one.now);
    one.contact.since = chunk_->begin + (n + 1 - made.share) * h_;
    one.contact.impact_speed = std::max(0.0, half.closing);
    if (one.j >= 0) followed_->record.begun.push_back(one.contact);
    add(one, geometry, one.now, &ActiveGrain::force, &ActiveGrain::torque);
    add(one, geometry, made.impulse, &ActiveGrain::impulse, &ActiveGrain::angular_impulse);
    followed_->record.dissipated += made.dissipated;
  }

  /// Ends a contact in substep n. Its forces act during a part of the substep.
  void end(RoughOpen& one, const SurfaceGeometry& geometry, const SurfaceMotion& half, int n) {
    const auto made = substep_of(one).end(half, one.overlap, one.last_overlap, one.spring, one.now);
    add(one, geometry, made.impulse, &ActiveGrain::impulse, &ActiveGrain::angular_impulse);
    followed_->record.dissipated += made.dissipated;
    one.open = false;
    --grains_.active()[one.i].contacts;
    if (one.j < 0) return;
    --grains_.active()[one.j].contacts;
    const double release = made.impulse.normal.force / reduced_mass(*bodies_, one.contact.pair) - half.closing;
    const Vec3 v = grains_.active()[one.i].velocity - grains_.active()[one.j].velocity;
    const double across = norm(v - dot(v, geometry.normal) * geometry.normal);
    followed_->record.ended.push_back({one.contact, release, chunk_->begin + (n + made.share) * h_, across});
    tests_.add(n + 2, {grains_.active()[one.i].slot, grains_.active()[one.j].slot});
  }

  /// Adds the forces of a contact to a force and a torque of its grains.
  void add(const RoughOpen& one, const SurfaceGeometry& geometry, const SurfaceForces& forces,
           Vec3 ActiveGrain::*linear, Vec3 ActiveGrain::*angular) {
    const auto [force, torque, other_torque] = load_of(geometry, forces);
    ActiveGrain& a = grains_.active()[one.i];
    a.*linear += force, a.*angular += torque;
    if (one.j < 0) return;
    ActiveGrain& b = grains_.active()[one.j];
    b.*linear -= force, b.*angular += other_torque;
  }

  const RoughLaws<Law>& laws_;
  const RoughSides& sides_;
  const Bodies* bodies_ = nullptr;
  NearestImage<3> nearest_{Box<3>{}};
  CellOrder<d> cells_;
  double widest_ = 0;
  double approach_ = 0;  ///< bound on the approach speed of two grains by contacts (v0)
  const RoughChunk* chunk_ = nullptr;
  ContactsFollowed* followed_ = nullptr;
  double h_ = 0;
  ActiveGrains grains_;
  ContactSchedule activations_, tests_;
  std::vector<RoughOpen> begun_;
};

}  // namespace lichtenberg::granular
