#pragma once

#include <cstdint>

#include "src/effects/wind.hpp"
#include "src/model/effect.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

struct GasDragOptions {
  double stokes = 0.05;         ///< S
  double speed = 0;             ///< sigma, v0
  double correlation_time = 1;  ///< tau_g, t0

  static const EffectKind& kind();
};

/// Drag S (v_gas - v) of a gas with a random velocity at each grain. It is Gaussian with standard deviation `speed` for
/// each component, constant for `correlation_time` (correlation time) and then redrawn (G 3.54, 7.2, which specify
/// neither). Grains without collisions reach the temperature speed^2 tanh(S hold / 2) at the times of redrawing. With
/// collisions the temperature is lower (validation/theory/driven_gas.hpp). Integrated exactly.
class GasDrag : public Effect {
 public:
  GasDrag(const GasDragOptions& options, std::uint64_t seed)
      : wind_{options.stokes, options.speed, options.correlation_time, seed} {}

  const EffectKind& kind() const override { return GasDragOptions::kind(); }
  std::optional<double> drive(double time, double dt, Bodies& bodies) override;

 private:
  Wind wind_;
};

}  // namespace lichtenberg::effects
