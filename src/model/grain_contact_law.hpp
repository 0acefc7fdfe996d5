#pragma once

#include <variant>

#include "src/model/linear_spring.hpp"
#include "src/model/viscoelastic.hpp"

namespace lichtenberg {

/// Contact force law of grains in reduced units: one of the laws that the variant lists. A law is a small struct with
///
/// ```
///     Real scale(Real radius_i, Real radius_j) const        // factor of the forces for these radii
///     ContactForceTerms<Real> force_terms(Real overlap, Real scale) const
///     ContactParts parts(double overlap, double scale) const
///     double shortest_contact(double speed) const           // duration for two undamped grains of mass 1
///     double damping_time(double speed) const               // time scale of the dashpot; infinite without one
///     HeadOnCollision collision(double effective_mass, double scale, double speed, const Solver& viscoelastic) const
///     Law times(double by) const                            // all forces larger by a factor
/// ```
///
/// for the host and a device. Real is a double or a SIMD vector, and `viscoelastic` computes the collision of
/// ViscoelasticLaw. On the host a law also has
///
/// ```
///     static constexpr bool constant_restitution            // true: restitution does not depend on the impact speed
///     Law undamped(double stiffness) const, stiffer(double stiffness) const
/// ```
///
/// for the functions `elastic` and `stiffer` below. Each law of the variant runs on the CPU and on devices. The list is
/// closed because the loops over contacts are compiled for each law: with vector instructions on the CPU, and as
/// kernels by nvcc.
struct GrainContactLaw : std::variant<ViscoelasticLaw, LinearSpringLaw> {
  using variant::variant;
};

/// Returns a contact law without damping whose elastic force is that of `law` times `stiffness`.
inline GrainContactLaw elastic(const GrainContactLaw& law, double stiffness) {
  return std::visit([&](const auto& one) { return GrainContactLaw(one.undamped(stiffness)); }, law);
}

/// Returns a contact law whose elastic force is that of `law` times `stiffness`, with the same restitution coefficient
/// at each impact speed. The damping increases by stiffness^(3/5) for viscoelastic spheres and by sqrt(stiffness) for
/// the linear spring.
inline GrainContactLaw stiffer(const GrainContactLaw& law, double stiffness) {
  return std::visit([&](const auto& one) { return GrainContactLaw(one.stiffer(stiffness)); }, law);
}

}  // namespace lichtenberg
