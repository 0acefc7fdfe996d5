#pragma once

#include <optional>

#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

struct LinearContactOptions {
  double stiffness = 278.6;  ///< A_l
  std::optional<double> restitution;
  std::optional<double> damping;  ///< B_l

  static const EffectKind& kind();
};

}  // namespace lichtenberg::effects
