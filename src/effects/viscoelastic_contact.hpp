#pragma once

#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

struct ViscoelasticContactOptions {
  double elastic = 278.6;     ///< E
  double dissipative = 27.7;  ///< D

  static const EffectKind& kind();
};

}  // namespace lichtenberg::effects
