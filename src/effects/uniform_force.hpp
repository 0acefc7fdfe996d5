#pragma once

#include "src/model/effect.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

/// Parameter of a uniform force on all grains: their constant acceleration. Reduced units.
struct UniformForceOptions {
  Coordinates acceleration;  ///< d0/t0^2

  static const EffectKind& kind();
};

/// Impulse of a uniform acceleration on one grain, dt * mass * acceleration, on the CPU and on a device.
struct UniformImpulse {
  Vec3 acceleration;  ///< d0/t0^2

  /// Returns component k of the impulse in a time dt (t0).
  LICHTENBERG_HOST_DEVICE double impulse(double dt, double mass, int k) const { return dt * mass * acceleration[k]; }
  LICHTENBERG_HOST_DEVICE void operator()(double, double dt, int, double mass, double* momentum, int d) const {
    for (int k = 0; k < d; ++k) momentum[k] += impulse(dt, mass, k);
  }
};

/// Effect of a uniform acceleration of all grains, such as weight. Its work counts as driving energy, because it has no
/// potential in a periodic box.
class UniformForce : public Effect {
 public:
  explicit UniformForce(const UniformForceOptions& options) : impulse_{options.acceleration.value} {}

  const EffectKind& kind() const override { return UniformForceOptions::kind(); }
  std::optional<double> drive(double time, double dt, Bodies& bodies) override;

 private:
  UniformImpulse impulse_;
};

}  // namespace lichtenberg::effects
