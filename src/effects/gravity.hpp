#pragma once

#include <optional>

#include "src/model/effect.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg {
struct Domain;
}

namespace lichtenberg::effects {

struct GravityOptions {
  double acceleration = 9.80665;  ///< m/s^2
  /// Direction of the fall, of any length; empty: the last axis downwards.
  std::optional<Coordinates> direction{};
  double fluid_density = 0;  ///< kg/m^3
  static const EffectKind& kind();
};

/// Returns the unit vector of the fall.
Vec3 down(const GravityOptions& options, const Domain& domain);

/// Weight minus buoyancy of spheres, 4/3 pi R^3 (density - fluid density) g (Archimedes).
class Gravity : public Effect {
 public:
  explicit Gravity(const Scene& scene);  ///< `scene` must have the effect

  const EffectKind& kind() const override { return GravityOptions::kind(); }
  void add_forces(const State& state, std::span<double> force) const override;
  /// Returns the potential energy relative to the origin, with unwrapped positions of bodies in a periodic box.
  double stored_energy(const State& state) const override;

 private:
  double weight(double radius) const;  ///< N
  double weight_density_;              ///< N/m^3, per volume
  Vec3 down_;                          ///< unit vector
};

}  // namespace lichtenberg::effects
