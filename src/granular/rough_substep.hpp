#pragma once

#include <cmath>

#include "src/granular/rough_sides.hpp"
#include "src/model/rough_contact.hpp"
#include "src/scene/grain_material.hpp"

namespace lichtenberg::granular {

/// Geometry of a contact of grain i with another grain or a wall, at one instant (d0).
struct SurfaceGeometry {
  Vec3 normal;  ///< unit vector from grain i to its partner
  double overlap = 0;
  double arm = 0, other_arm = 0;  ///< distances of the contact from the centres of i and of its partner
};
/// Returns the geometry of the contact of two grains of radii ri and rj. `separation`: vector from i to j, of length
/// `distance`.
LICHTENBERG_HOST_DEVICE inline SurfaceGeometry geometry_of_pair(Vec3 separation, double distance, double ri,
                                                                double rj) {
  const double sum = ri + rj;
  return {separation / distance, sum - distance, distance * ri / sum, distance * rj / sum};
}
/// Returns the geometry of the contact of a grain and a side at this gap.
LICHTENBERG_HOST_DEVICE inline SurfaceGeometry geometry_at_side(int side, double gap, double radius) {
  return {RoughSides::normal(side), -gap, radius + gap, 0};
}

/// Velocity (v0) and angular velocity (1/t0) of a grain; those of a wall are 0.
struct RigidMotion {
  Vec3 velocity, spin;
};
/// Returns the relative motion of the surfaces of grain i and its partner. `step`: substep (t0).
LICHTENBERG_HOST_DEVICE inline SurfaceMotion surface_motion(const SurfaceGeometry& geometry, const RigidMotion& i,
                                                            const RigidMotion& partner, double step) {
  const Vec3 n = geometry.normal, v = i.velocity - partner.velocity, w = i.spin - partner.spin;
  const Vec3 turning = geometry.arm * i.spin + geometry.other_arm * partner.spin;
  const Vec3 surface = v + cross(turning, n);
  return {n, geometry.overlap, dot(v, n), surface - dot(surface, n) * n, w - dot(w, n) * n, step};
}

/// Forces, or impulses, of a contact on its two grains.
struct SurfaceLoad {
  Vec3 force;                 ///< on i; the opposite acts on the partner
  Vec3 torque, other_torque;  ///< on i and on its partner
};
LICHTENBERG_HOST_DEVICE inline SurfaceLoad load_of(const SurfaceGeometry& geometry, const SurfaceForces& forces) {
  const Vec3 turning = cross(geometry.normal, forces.tangential);
  return {forces.tangential - forces.normal.force * geometry.normal, geometry.arm * turning + forces.couple,
          geometry.other_arm * turning - forces.couple};
}

/// A substep of one contact. Forces at its end depend on velocities that are predicted with the forces at its start.
/// `half` and `end` are the motions with the velocities in the middle and with those predicted for the end, both with
/// the geometry at the end. For the host and for a device.
template <class Law>
struct RoughSubstep {
  /// A substep in which the contact acts during a part only, at the end (onset) or at the start.
  struct PartialSubstep {
    double share = 1;         ///< part of the substep
    SurfaceForces impulse{};  ///< in addition to the impulse of the half steps with the forces at start and end
    double dissipated = 0;    ///< energy
  };

  const RoughContactLaw<Law>& law;
  const RoughPair& constants;
  double h;  ///< substep (t0)

  LICHTENBERG_HOST_DEVICE static double energy_of(const TangentialSpring& spring) {
    return 0.5 * spring.stiffness * norm2(spring.elongation);
  }

  /// Computes the forces `now` at the end of a substep during which the contact lasts, from those at its start. Returns
  /// the dissipated energy.
  LICHTENBERG_HOST_DEVICE double proceed(const SurfaceMotion& half, const SurfaceMotion& end, TangentialSpring& spring,
                                         SurfaceForces& now) const {
    const SurfaceForces before = now;
    const double stored = energy_of(spring);
    const Vec3 path = h * half.sliding;
    now = law.forces(constants, end, path, spring);
    return 0.5 * h * (before.normal.dissipated + now.normal.dissipated + before.rolling_power + now.rolling_power) -
           0.5 * dot(before.tangential + now.tangential, path) + stored - energy_of(spring);
  }

  /// Computes the forces `now` at the end of the substep in which the contact has begun.
  LICHTENBERG_HOST_DEVICE PartialSubstep begin(const SurfaceMotion& half, const SurfaceMotion& end,
                                               TangentialSpring& spring, SurfaceForces& now) const {
    PartialSubstep made;
    made.share = within_one(half.overlap / (h * half.closing));
    SurfaceMotion first = half;
    first.overlap = 0;
    TangentialSpring unstretched;
    const SurfaceForces onset = law.forces(constants, first, {}, unstretched);
    const Vec3 path = made.share * h * half.sliding;
    now = law.forces(constants, end, path, spring);
    // Impulse share/2 h (onset + end), of which the regular half step gives h/2 end.
    const double part = 0.5 * made.share * h;
    made.impulse.normal.force = part * onset.normal.force + (part - 0.5 * h) * now.normal.force;
    made.impulse.tangential = part * onset.tangential + (part - 0.5 * h) * now.tangential;
    made.impulse.couple = part * onset.couple + (part - 0.5 * h) * now.couple;
    made.dissipated =
        part * (onset.normal.dissipated + now.normal.dissipated + onset.rolling_power + now.rolling_power) -
        0.5 * dot(onset.tangential + now.tangential, path) - energy_of(spring);
    return made;
  }

  /// Ends a contact that had the forces `now` and the overlap `before` at the start of the substep. `last`: overlap at
  /// which contacts end.
  LICHTENBERG_HOST_DEVICE PartialSubstep end(const SurfaceMotion& half, double before, double last,
                                             const TangentialSpring& spring, const SurfaceForces& now) const {
    PartialSubstep made;
    made.share = within_one((before - last) / (before - half.overlap));
    const NormalContact separating = law.normal_contact(constants, last, half.closing);
    const double mean = law.mean_tangential(now, separating.pressing);
    // Impulse share/2 h (start + end), of which the regular half step has given h/2 start.
    const double part = 0.5 * made.share * h;
    made.impulse = now;
    made.impulse.normal.force = (part - 0.5 * h) * now.normal.force + part * separating.force;
    made.impulse.tangential *= 2 * part * mean - 0.5 * h;
    made.impulse.couple *= part - 0.5 * h;
    made.dissipated = part * (now.normal.dissipated + separating.dissipated + now.rolling_power) + separating.stored -
                      2 * part * mean * dot(now.tangential, half.sliding) + energy_of(spring);
    return made;
  }

 private:
  LICHTENBERG_HOST_DEVICE static double within_one(double share) { return share < 0 ? 0 : share > 1 ? 1 : share; }
};

}  // namespace lichtenberg::granular
