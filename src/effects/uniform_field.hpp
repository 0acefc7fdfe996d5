#pragma once

#include "src/model/effect.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

/// Parameter of an external uniform electric field on grains. Reduced units.
struct UniformFieldOptions {
  Coordinates field;  ///< E, m0 v0^2/(q0 d0)

  static const EffectKind& kind();
};

/// Force and energy of a charge in a uniform field, on the CPU and on a device. Reduced units.
struct FieldOnCharge {
  Vec3 field;  ///< E, m0 v0^2/(q0 d0)

  /// Returns component k of the force on a charge.
  LICHTENBERG_HOST_DEVICE double force(double charge, int k) const { return charge * field[k]; }
  /// Returns the energy of a charge along axis k; `coordinate`: unwrapped (d0).
  LICHTENBERG_HOST_DEVICE double energy(double charge, double coordinate, int k) const {
    return -(charge * field[k] * coordinate);
  }
};

/// Effect of an external uniform electric field E: the force q E on a grain of charge q, with the energy -q E.r. Along
/// periodic axes r is the unwrapped position.
class UniformField : public Effect {
 public:
  explicit UniformField(const UniformFieldOptions& options) : law_{options.field.value} {}

  const EffectKind& kind() const override { return UniformFieldOptions::kind(); }
  Needs needs() const override { return {.charges = true}; }
  void add_forces(const State& state, std::span<double> force) const override;
  double stored_energy(const State& state) const override;

 private:
  FieldOnCharge law_;
};

}  // namespace lichtenberg::effects
