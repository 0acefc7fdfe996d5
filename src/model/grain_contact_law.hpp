#pragma once

#include <variant>

#include "src/model/linear_spring.hpp"
#include "src/model/viscoelastic.hpp"

namespace lichtenberg {

/// How grains in contact push each other.
struct GrainContactLaw : std::variant<ViscoelasticLaw, LinearSpringLaw> {
  using variant::variant;
};

/// Without damping, and `stiffness` times as stiff.
GrainContactLaw elastic(const GrainContactLaw& law, double stiffness);

/// `stiffness` times as stiff, and damped so that the restitution is the same at each speed: D times stiffness^(3/5), B
/// times its root.
GrainContactLaw stiffer(const GrainContactLaw& law, double stiffness);

/// How long two grains of diameter 1 and mass 1 that meet at this speed are in contact, if nothing is lost: no contact
/// of theirs is shorter. Hertz: 3.21806 (m_eff^2 / (E^2 speed))^(1/5); linear: pi sqrt(m_eff / A).
double shortest_contact(const GrainContactLaw& law, double speed);

}  // namespace lichtenberg
