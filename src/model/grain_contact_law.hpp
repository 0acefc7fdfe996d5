#pragma once

#include <variant>

#include "src/model/linear_spring.hpp"
#include "src/model/viscoelastic.hpp"

namespace lichtenberg {

/// Contact force law of grains: one law of this list. A law is a small struct with
///
/// ```
///     Real scale(Real radius_i, Real radius_j) const        // factor of the forces by the radii
///     ContactForceTerms<Real> force_terms(Real overlap, Real scale) const
///     ContactParts parts(double overlap, double scale) const
///     double shortest_contact(double speed) const           // duration for two undamped grains of mass 1
///     double damping_time(double speed) const               // time scale of the dashpot; infinite without one
///     HeadOnCollision collision(double effective_mass, double scale, double speed, const Solver& viscoelastic) const
///     Law times(double by) const                            // all forces larger by a factor
/// ```
///
/// for the host and a device, where Real is a number or several in a vector and `viscoelastic` solves the collision of
/// ViscoelasticLaw, and
///
/// ```
///     static constexpr bool constant_restitution            // true: it does not depend on the impact speed
///     Law undamped(double stiffness) const, stiffer(double stiffness) const
/// ```
///
/// as `elastic` and `stiffer` below. A law in this list runs on the CPU and on devices. The list is closed because each
/// loop over contacts is compiled for each law: with vector instructions on the CPU, and as kernels by nvcc.
struct GrainContactLaw : std::variant<ViscoelasticLaw, LinearSpringLaw> {
  using variant::variant;
};

/// Returns the law without damping, and `stiffness` times as stiff.
inline GrainContactLaw elastic(const GrainContactLaw& law, double stiffness) {
  return std::visit([&](const auto& one) { return GrainContactLaw(one.undamped(stiffness)); }, law);
}

/// Returns the law `stiffness` times as stiff, with damping that keeps the restitution at each speed: D times
/// stiffness^(3/5), B times its square root.
inline GrainContactLaw stiffer(const GrainContactLaw& law, double stiffness) {
  return std::visit([&](const auto& one) { return GrainContactLaw(one.stiffer(stiffness)); }, law);
}

}  // namespace lichtenberg
