#pragma once

#include <optional>

#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

/// Parameters of the viscoelastic contact of grains (ViscoelasticLaw): E and D in reduced units, or material constants
/// in SI from which they follow.
struct ViscoelasticContactOptions {
  double elastic = 278.6;     ///< E
  double dissipative = 27.7;  ///< D
  // Alternative parameters in SI:
  std::optional<double> young;      ///< Young's modulus Y (Pa)
  std::optional<double> poisson;    ///< Poisson's ratio nu
  std::optional<double> viscosity;  ///< dissipation time gamma of the material (s)

  static const EffectKind& kind();
};

}  // namespace lichtenberg::effects
