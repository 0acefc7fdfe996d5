#pragma once

#include "src/model/effect.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

struct StokesDragOptions {
  static const EffectKind& kind();
};

/// Effect of Stokes drag on spheres, force F = -6 pi viscosity R v (Stokes 1851; Stephenson 2018, eq. 5.8).
class StokesDrag : public Effect {
 public:
  explicit StokesDrag(double viscosity) : viscosity_(viscosity) {}  ///< Pa s

  const EffectKind& kind() const override { return StokesDragOptions::kind(); }
  DragLaw drag(const Bodies& bodies, int body) const override;

 private:
  double viscosity_;
};

}  // namespace lichtenberg::effects
