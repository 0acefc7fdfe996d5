#pragma once

#include <cstdint>

#include "src/effects/wind.hpp"
#include "src/model/effect.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

struct GasDragOptions {
  double stokes = 0.05;  ///< S
  double speed = 0;      ///< sigma, v0
  double hold = 1;       ///< tau_g, t0

  static const EffectKind& kind();
};

/// Drag S (v_gas - v) of a gas whose velocity at each grain is random: Gaussian, of standard deviation `speed` a
/// component, the same for `hold`, then drawn anew (G 3.54, 7.2, which state neither). Grains that do not
/// collide come to the temperature speed^2 tanh(S hold / 2) when it is drawn anew; colliding ones to a lower one
/// (theory::driven_temperature). Solved exactly.
class GasDrag : public Effect {
 public:
  GasDrag(const GasDragOptions& options, std::uint64_t seed)
      : wind_{options.stokes, options.speed, options.hold, seed} {}

  const EffectKind& kind() const override { return GasDragOptions::kind(); }
  std::optional<double> drive(double time, double dt, Bodies& bodies) override;

 private:
  Wind wind_;
};

}  // namespace lichtenberg::effects
