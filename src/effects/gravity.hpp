#pragma once

#include "src/model/effect.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

struct GravityOptions {
  double acceleration = 9.80665;  ///< m/s^2, to the front in three dimensions, to the bottom in two
  double fluid_density = 0;       ///< kg/m^3
  static const EffectKind& kind();
};

/// Weight less buoyancy of spheres, 4/3 pi R^3 (density - fluid density) g (Archimedes).
class Gravity : public Effect {
 public:
  explicit Gravity(const Scene& scene);  ///< which has it

  const EffectKind& kind() const override { return GravityOptions::kind(); }
  void add_forces(const State& state, std::span<double> force) const override;
  double stored_energy(const State& state) const override;  ///< from z = 0 of three dimensions on, y = 0 of two

 private:
  double pull(double radius) const;  ///< N
  double pull_;                      ///< N/m^3, of the volume
};

}  // namespace lichtenberg::effects
