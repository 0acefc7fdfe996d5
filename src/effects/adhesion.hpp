#pragma once

#include "src/model/surface_law.hpp"
#include "src/scene/choice.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg {
template <>
inline constexpr Named<AdhesionModel> values_named<AdhesionModel>[] = {{AdhesionModel::dmt, "dmt"},
                                                                       {AdhesionModel::jkr, "jkr"}};
}

namespace lichtenberg::effects {

/// Parameters of the adhesion of grains (AdhesionLaw).
struct AdhesionOptions {
  AdhesionModel model = AdhesionModel::jkr;
  double surface_energy = 0;  ///< J/m^2

  static const EffectKind& kind();
};

}  // namespace lichtenberg::effects
