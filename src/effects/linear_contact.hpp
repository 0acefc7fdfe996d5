#pragma once

#include <optional>

#include "src/model/linear_spring.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

/// Parameters of the linear spring-dashpot contact of grains (LinearSpringLaw), in reduced units. If both optional
/// members are empty, the restitution coefficient is 0.9.
struct LinearContactOptions {
  double stiffness = 278.6;           ///< stiffness A (m0/t0^2)
  std::optional<double> restitution;  ///< restitution coefficient of two grains of mass m0
  std::optional<double> damping;      ///< damping B (m0/t0), instead of `restitution`

  static const EffectKind& kind();
};

/// Returns the contact law of these options.
LinearSpringLaw linear_law(const LinearContactOptions& options);

}  // namespace lichtenberg::effects
