#pragma once

#include "src/model/effect.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

struct StokesDragOptions {
  static const EffectKind& kind();
};

/// F = -gamma v with gamma = 6 pi viscosity R (D 5.8).
class StokesDrag : public Effect {
 public:
  explicit StokesDrag(double viscosity) : viscosity_(viscosity) {}  ///< Pa s

  const EffectKind& kind() const override { return StokesDragOptions::kind(); }
  void add_forces(const State& state, std::span<double> force) const override;
  void add_jacobian(const State& state, ForceJacobian& jacobian) const override;
  bool is_held_or_drag() const override { return true; }
  /// gamma of a sphere (kg/s); radius in m.
  double drag_coefficient(double radius) const override;

 private:
  double viscosity_;
};

}  // namespace lichtenberg::effects
