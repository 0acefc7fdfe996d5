#pragma once

#include "src/model/effect.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

struct UniformForceOptions {
  Coordinates acceleration;  ///< d0 / t0^2

  static const EffectKind& kind();
};

/// Weight, say: every grain is accelerated alike. What it does to the grains is booked as driven: in a periodic box it
/// has no potential.
class UniformForce : public Effect {
 public:
  explicit UniformForce(const UniformForceOptions& options) : acceleration_(options.acceleration.value) {}

  const EffectKind& kind() const override { return UniformForceOptions::kind(); }
  std::optional<double> drive(double time, double dt, Bodies& bodies) override;

 private:
  Vec3 acceleration_;
};

}  // namespace lichtenberg::effects
