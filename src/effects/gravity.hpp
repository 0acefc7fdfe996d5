#pragma once

#include <optional>

#include "src/model/effect.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg {
struct Domain;
}

namespace lichtenberg::effects {

/// Parameters of weight and buoyancy: gravitational acceleration, its direction, and density of the fluid.
struct GravityOptions {
  double acceleration = 9.80665;  ///< gravitational acceleration (m/s^2)
  /// Direction of gravity, a vector of any length but 0; empty: along the last axis (y or z) towards 0.
  std::optional<Coordinates> direction{};
  double fluid_density = 0;  ///< density of the fluid, for buoyancy (kg/m^3)
  static const EffectKind& kind();
};

/// Returns the unit vector in the direction of gravity.
Vec3 down(const GravityOptions& options, const Domain& domain);

/// Effect of gravity: weight minus buoyancy of spheres, 4/3 pi R^3 (density - fluid density) g (Archimedes).
class Gravity : public Effect {
 public:
  explicit Gravity(const Scene& scene);  ///< `scene` must have the effect

  const EffectKind& kind() const override { return GravityOptions::kind(); }
  void add_forces(const State& state, std::span<double> force) const override;
  /// Returns the gravitational potential energy (J) of all bodies relative to the origin. In a periodic box it uses the
  /// unwrapped positions.
  double stored_energy(const State& state) const override;

 private:
  double weight(double radius) const;  ///< N
  double weight_density_;              ///< N/m^3, per volume
  Vec3 down_;                          ///< unit vector
};

}  // namespace lichtenberg::effects
