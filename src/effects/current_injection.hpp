#pragma once

#include "src/model/effect.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

/// Parameter of current injection: the constant current into each conductor.
struct CurrentInjectionOptions {
  double current = 0;  ///< current into each conductor (A)
  static const EffectKind& kind();
};

/// Effect that injects the same constant current into every conductor, dQ_i/dt = current (Stephenson 2018, eq. 5.5).
/// The potential source of a conductor at a prescribed potential collects its current immediately.
class CurrentInjection : public Effect {
 public:
  explicit CurrentInjection(double current) : current_(current) {}  ///< A

  const EffectKind& kind() const override { return CurrentInjectionOptions::kind(); }
  Needs needs() const override { return {.charges = true}; }
  void add_currents(const State&, std::span<double> current) const override {
    for (double& c : current) c += current_;
  }

 private:
  double current_;
};

}  // namespace lichtenberg::effects
