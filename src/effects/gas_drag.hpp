#pragma once

#include <cstdint>

#include "src/effects/wind.hpp"
#include "src/model/effect.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

/// Parameters of the drag of a surrounding gas on grains: drag coefficient, and speed and correlation time of the
/// random gas velocity. Reduced units.
struct GasDragOptions {
  double stokes = 0.05;         ///< drag coefficient S (1/t0)
  double speed = 0;             ///< standard deviation of each component of the gas velocity (v0)
  double correlation_time = 1;  ///< time after which the gas velocity is redrawn (t0)

  static const EffectKind& kind();
};

/// Effect of drag in a gas with random velocities: acceleration S (v_gas - v) of each grain (Singh 2019, eq. 3.54,
/// 7.2). The gas velocity v_gas at a grain is Gaussian with standard deviation `speed` for each component. It is
/// constant for a time h = `correlation_time` and then redrawn.
///
/// Grains of mass m0 without collisions reach the temperature speed^2 tanh(S h / 2) at the times of redrawing. With
/// collisions the temperature is lower (validation/theory/driven_gas.hpp). For S h << 1 the effect is a
/// Langevin thermostat: without collisions the temperature is speed^2 S h / 2. The drag is integrated exactly.
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
