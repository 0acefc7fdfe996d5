#pragma once

#include <optional>

#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

struct ViscoelasticContactOptions {
  double elastic = 278.6;     ///< E
  double dissipative = 27.7;  ///< D
  // Alternative parameters in SI:
  std::optional<double> young;      ///< Y, Pa
  std::optional<double> poisson;    ///< nu
  std::optional<double> viscosity;  ///< gamma, s

  static const EffectKind& kind();
};

}  // namespace lichtenberg::effects
