#pragma once

#include <optional>

#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

/// Parameters of flat walls at the sides of the domain of grains. Empty values are those of the contact of two grains.
struct FlatWallsOptions {
  std::optional<double> stiffness;    ///< E or A of the contact of a grain and a wall
  std::optional<double> damping;      ///< D or B
  std::optional<double> restitution;  ///< of a grain of mass m0 at a wall, with linear_contact
  std::optional<double> friction;     ///< mu
  // Alternative parameters of the wall's material in SI, with viscoelastic_contact:
  std::optional<double> young;      ///< Young's modulus (Pa)
  std::optional<double> poisson;    ///< Poisson's ratio
  std::optional<double> viscosity;  ///< dissipation time of the material (s)

  static const EffectKind& kind();
};

}  // namespace lichtenberg::effects
