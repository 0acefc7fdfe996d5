#pragma once

#include "src/model/effect.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

struct CurrentInjectionOptions {
  double current = 0;  ///< A
  static const EffectKind& kind();
};

/// Current injection: dQ_i/dt = current for every conductor, including grounded ones, whose current is collected
/// immediately (D 5.5).
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
