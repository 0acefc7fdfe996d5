#pragma once

#include <cmath>
#include <numbers>

#include "solvers/geometry/vec.hpp"
#include "src/model/contact_force.hpp"
#include "src/model/surface_law.hpp"

namespace lichtenberg {

/// Constants of the contact of two grains, or of a grain and a wall, that do not change during the contact. Reduced
/// units.
struct RoughPair {
  double scale = 1;              ///< factor of the normal law for radii and materials
  double damping = 1;            ///< factor of its damping for the materials, in addition
  double effective_radius = 0;   ///< R_i R_j / (R_i + R_j); R_i at a wall
  double effective_inertia = 0;  ///< I_i I_j / (I_i + I_j); I_i at a wall
};

/// Normal force of a contact at one instant, in reduced units.
struct NormalContact {
  double force = 0;       ///< repulsive; negative for attraction
  double dissipated = 0;  ///< power
  double stored = 0;      ///< potential energy; 0 at the overlap 0
  double pressing = 0;    ///< force to which Coulomb's law applies: the normal force plus the pull-off force
  double slope = 0;       ///< stiffness against small normal displacements, without adhesion
  double damping = 0;     ///< damping coefficient
};

/// Contact of elastic spheres with adhesion (Johnson, Kendall and Roberts 1971) for a work of adhesion w, effective
/// radius R and effective modulus E*. With the contact radius a = a0 s^2, a0 = (2 pi w R^2 / E*)^(1/3):
///
///   overlap = d0 (s^4 - s),  d0 = a0^2 / R,        force = 2 pi w R (4/3 s^6 - 2 s^3).
///
/// A contact begins at the overlap 0 (s = 1) and ends at s = 4^(-1/3), where the overlap is smallest. The energy is the
/// integral of the force from the overlap 0 on. At the end it is 0.3315 * 2 pi w R d0 = 7.09 (w^5 R^4 / E*^2)^(1/3),
/// which the contact loses in a cycle.
struct JkrContact {
  double force_unit = 0;   ///< 2 pi w R
  double length = 0;       ///< d0
  double radius_unit = 0;  ///< a0

  static constexpr double last = 0.62996052494743658;  ///< s = 4^(-1/3) at the end of a contact

  LICHTENBERG_HOST_DEVICE JkrContact(double work, double effective_radius, double modulus)
      : force_unit(2 * std::numbers::pi * work * effective_radius),
        radius_unit(std::cbrt(force_unit * effective_radius / modulus)) {
    length = radius_unit * radius_unit / effective_radius;
  }

  /// Returns the overlap, negative, at which a contact ends.
  LICHTENBERG_HOST_DEVICE double last_overlap() const { return length * last * (last * last * last - 1); }
  /// Returns s at an overlap of at least last_overlap(). Newton's method converges from above, because s^4 - s is
  /// convex.
  LICHTENBERG_HOST_DEVICE double root(double overlap) const {
    const double x = overlap / length;
    if (x <= last * (last * last * last - 1)) return last;
    double s = x > 0 ? 1 + std::sqrt(std::sqrt(x)) : 1;
    for (int k = 0; k < 60; ++k) {
      const double next = s - (s * (s * s * s - 1) - x) / (4 * s * s * s - 1);
      if (!(next < s)) break;
      s = next;
    }
    return s > last ? s : last;
  }
  LICHTENBERG_HOST_DEVICE double force(double s) const {
    const double cube = s * s * s;
    return force_unit * cube * (4.0 / 3 * cube - 2);
  }
  /// Returns the integral of the force from the overlap 0 to that of s.
  LICHTENBERG_HOST_DEVICE double energy(double s) const {
    const double cube = s * s * s, fourth = cube * s;
    return force_unit * length * (fourth * (8.0 / 15 * cube * cube - 4.0 / 3 * cube + 0.5) + 0.3);
  }
  LICHTENBERG_HOST_DEVICE double pull_off() const { return 0.75 * force_unit; }  ///< 3/2 pi w R
};

/// Relative motion of the two surfaces at a contact at one instant, in reduced units. Vectors of two dimensions have z
/// = 0, and angular velocities are along z.
struct SurfaceMotion {
  Vec3 normal;  ///< unit vector from grain i to its partner
  double overlap = 0;
  double closing = 0;      ///< approach speed of the centres along the normal
  Vec3 sliding;            ///< velocity of the surface of i relative to that of the partner, across the normal
  Vec3 rolling;            ///< relative angular velocity of i, across the normal
  double step = INFINITY;  ///< substep (t0): a rolling torque does not reverse the rotation within it
};

/// Tangential spring of a contact.
struct TangentialSpring {
  Vec3 elongation;       ///< d0
  double stiffness = 0;  ///< at the last instant
};

/// Forces of a contact on grain i at one instant, in reduced units.
struct SurfaceForces {
  NormalContact normal;
  Vec3 tangential;           ///< force on i across the normal
  Vec3 couple;               ///< torque on i against rolling; the opposite acts on the partner
  double rolling_power = 0;  ///< dissipated power of the couple
};

/// Law of the forces between two rough grains in contact, or between a grain and a wall. It has the normal law with
/// adhesion, the tangential spring with Coulomb's law, and the rolling resistance. `Law` is one of GrainContactLaw. For
/// the host and for a device.
///
/// The tangential stiffness is a constant ratio to the normal stiffness. As that changes with the overlap, the spring
/// keeps its force under loading and its elongation under unloading, so that no energy is created (Thornton, Cummins
/// and Cleary 2013).
template <class Law>
struct RoughContactLaw {
  Law normal;
  FrictionLaw friction;
  AdhesionLaw adhesion;

  /// Returns the JKR contact of a pair. E* follows from Hertz's force 4/3 E* sqrt(R) xi^(3/2).
  LICHTENBERG_HOST_DEVICE JkrContact jkr(const RoughPair& pair) const {
    const double modulus = 0.75 * normal.force_terms(1.0, pair.scale).elastic / std::sqrt(pair.effective_radius);
    return {adhesion.work, pair.effective_radius, modulus};
  }
  /// Returns the overlap at which an open contact ends: 0, or negative for JKR.
  LICHTENBERG_HOST_DEVICE double last_overlap(const RoughPair& pair) const {
    return adhesion.model == AdhesionModel::jkr ? jkr(pair).last_overlap() : 0;
  }

  /// Returns the normal force of an open contact. `closing`: approach speed. Without adhesion it is that of
  /// contact_force(). DMT adds the constant attraction 2 pi w R. For JKR the dashpot has the contact radius of JKR, and
  /// the force is not below the pull-off force.
  LICHTENBERG_HOST_DEVICE NormalContact normal_contact(const RoughPair& pair, double overlap, double closing) const {
    if (adhesion.model == AdhesionModel::jkr) return jkr_contact(jkr(pair), pair, overlap, closing);
    const ContactParts parts = parts_at(pair, overlap > 0 ? overlap : 0);
    const ContactForce contact = contact_force(parts, closing);
    const double attraction =
        adhesion.model == AdhesionModel::dmt ? 2 * std::numbers::pi * adhesion.work * pair.effective_radius : 0;
    return {contact.force - attraction,
            contact.dissipated,
            parts.stored - attraction * (overlap > 0 ? overlap : 0),
            contact.force,
            parts.elastic_slope,
            parts.damping};
  }

  /// Returns the stored energy of a contact with this elongation of its tangential spring.
  LICHTENBERG_HOST_DEVICE double energy(const RoughPair& pair, double overlap, Vec3 elongation) const {
    const NormalContact now = normal_contact(pair, overlap, 0);
    return now.stored + 0.5 * friction.stiffness_ratio * now.slope * norm2(elongation);
  }

  /// Returns the forces on grain i. `spring` is moved by `displacement` (d0), the path of the surface of i relative to
  /// its partner since the last instant. In a sliding contact it is shortened to the length that Coulomb's law allows.
  LICHTENBERG_HOST_DEVICE SurfaceForces forces(const RoughPair& pair, const SurfaceMotion& motion, Vec3 displacement,
                                               TangentialSpring& spring) const {
    SurfaceForces all{.normal = normal_contact(pair, motion.overlap, motion.closing)};
    if (friction.coefficient > 0) all.tangential = tangential(all.normal, motion, displacement, spring);
    if (friction.rolling_coefficient > 0) add_rolling(pair, motion, all);
    return all;
  }

  /// Returns the mean tangential force from now to the end of the contact over its present value. The spring keeps its
  /// force, which Coulomb's law limits while the pressing force changes linearly to `pressing`.
  LICHTENBERG_HOST_DEVICE double mean_tangential(const SurfaceForces& now, double pressing) const {
    const double force = norm(now.tangential), first = friction.coefficient * now.normal.pressing,
                 last = friction.coefficient * pressing;
    if (!(force > last)) return 1;
    if (!(force < first)) return 0.5 * (first + last) / force;
    const double sticking = (first - force) / (first - last);
    return sticking + (1 - sticking) * 0.5 * (force + last) / force;
  }

 private:
  LICHTENBERG_HOST_DEVICE ContactParts parts_at(const RoughPair& pair, double overlap) const {
    ContactParts parts = normal.parts(overlap, pair.scale);
    parts.damping *= pair.damping;
    return parts;
  }
  LICHTENBERG_HOST_DEVICE NormalContact jkr_contact(const JkrContact& jkr, const RoughPair& pair, double overlap,
                                                    double closing) const {
    const double s = jkr.root(overlap), radius = jkr.radius_unit * s * s;
    const double hertzian = radius * radius / pair.effective_radius;  // overlap of a Hertz contact of this radius
    const ContactParts parts = parts_at(pair, hertzian);
    const double elastic = jkr.force(s), attraction = jkr.pull_off(), damped = elastic + parts.damping * closing;
    const double force = damped > -attraction ? damped : -attraction;
    return {force, (force - elastic) * closing, jkr.energy(s), force + attraction, parts.elastic_slope, parts.damping};
  }

  LICHTENBERG_HOST_DEVICE Vec3 tangential(const NormalContact& now, const SurfaceMotion& motion, Vec3 displacement,
                                          TangentialSpring& spring) const {
    const double stiffness = friction.stiffness_ratio * now.slope, most = friction.coefficient * now.pressing;
    rotate(motion.normal, spring.elongation);
    if (spring.stiffness > 0 && spring.stiffness < stiffness) spring.elongation *= spring.stiffness / stiffness;
    spring.elongation += displacement;
    spring.stiffness = stiffness;
    if (const double elastic = stiffness * norm(spring.elongation); elastic > most) spring.elongation *= most / elastic;
    const Vec3 force = -stiffness * spring.elongation - friction.damping_ratio * now.damping * motion.sliding;
    const double size = norm(force);
    return size > most ? (most / size) * force : force;
  }
  /// Rotates a vector into the plane across `normal`, with unchanged length.
  LICHTENBERG_HOST_DEVICE static void rotate(Vec3 normal, Vec3& vector) {
    const double before = norm2(vector);
    if (before == 0) return;
    vector -= dot(vector, normal) * normal;
    const double after = norm2(vector);
    vector *= after > 0 ? std::sqrt(before / after) : 0;
  }

  LICHTENBERG_HOST_DEVICE void add_rolling(const RoughPair& pair, const SurfaceMotion& motion,
                                           SurfaceForces& all) const {
    const double rate = norm(motion.rolling);
    if (!(rate > 0)) return;
    const double most = friction.rolling_coefficient * pair.effective_radius * all.normal.pressing;
    const double stopping = pair.effective_inertia * rate / motion.step;
    const double torque = most < stopping ? most : stopping;
    all.couple = (-torque / rate) * motion.rolling;
    all.rolling_power = torque * rate;
  }
};

}  // namespace lichtenberg
