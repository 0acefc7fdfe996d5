#pragma once

#include "src/model/effect.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

/// Parameter of charge leakage through the fluid: its conductivity.
struct LeakageOptions {
  double conductivity = 0;  ///< conductivity of the fluid (S/m)
  static const EffectKind& kind();
};

/// Effect of charge leakage by ohmic conduction through the uniform fluid. No charge accumulates in the fluid. The
/// charge Q of a conductor leaks at the rate Q / tau, whatever surrounds it (Gauss's and Ohm's laws). The charge
/// relaxation time is tau = permittivity / conductivity.
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
