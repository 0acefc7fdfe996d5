#pragma once

#include <optional>

#include "src/model/effect.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg {
struct Domain;
}

namespace lichtenberg::effects {

struct GravityOptions {
  double acceleration = 9.80665;           ///< m/s^2
  std::optional<Coordinates> direction{};  ///< of the fall, of any length; empty: the last axis downwards
  double fluid_density = 0;                ///< kg/m^3
  static const EffectKind& kind();
};

/// Unit vector of the fall.
Vec3 down(const GravityOptions& options, const Domain& domain);

/// Weight less buoyancy of spheres, 4/3 pi R^3 (density - fluid density) g (Archimedes).
class Gravity : public Effect {
 public:
  explicit Gravity(const Scene& scene);  ///< which has it

  const EffectKind& kind() const override { return GravityOptions::kind(); }
  void add_forces(const State& state, std::span<double> force) const override;
  /// From the origin on. A body that has gone around a periodic box counts where it would be without the box.
  double stored_energy(const State& state) const override;

 private:
  double pull(double radius) const;  ///< N
  double pull_;                      ///< N/m^3, of the volume
  Vec3 down_;                        ///< unit vector
};

}  // namespace lichtenberg::effects
