#pragma once

#include "src/model/effect.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

struct LeakageOptions {
  double conductivity = 0;  ///< S/m
  static const EffectKind& kind();
};

/// Ohmic conduction through the uniform fluid. No charge accumulates in the fluid, and every conductor's charge decays
/// with the relaxation time permittivity / conductivity, whatever surrounds it (Gauss and Ohm).
class Leakage : public Effect {
 public:
  Leakage(const LeakageOptions& options, double permittivity)  ///< F/m
      : relaxation_time_(permittivity / options.conductivity) {}

  const EffectKind& kind() const override { return LeakageOptions::kind(); }
  Needs needs() const override { return {.charges = true}; }
  double charge_relaxation_time() const override { return relaxation_time_; }

 private:
  double relaxation_time_;  ///< s
};

}  // namespace lichtenberg::effects
