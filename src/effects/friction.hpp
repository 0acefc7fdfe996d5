#pragma once

#include <optional>

#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

/// Parameters of friction and rotation of grains (FrictionLaw).
struct FrictionOptions {
  double coefficient = 0.5;                      ///< mu
  double stiffness_ratio = 2.0 / 7;              ///< tangential over normal stiffness
  std::optional<double> damping_ratio;           ///< tangential over normal damping; default: stiffness_ratio
  std::optional<double> tangential_restitution;  ///< beta_0 of sticking contacts without tangential damping
  double rolling_coefficient = 0;                ///< mu_r
  double inertia = 0.4;                          ///< moment of inertia over mass times squared radius

  static const EffectKind& kind();
};

}  // namespace lichtenberg::effects
