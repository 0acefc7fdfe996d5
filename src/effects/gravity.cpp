#include "src/effects/gravity.hpp"

#include <cmath>
#include <numbers>

#include "src/scene/scene.hpp"

namespace lichtenberg::effects {

const EffectKind& GravityOptions::kind() {
  static const EffectKind kind = {
      .name = "gravity",
      .description = "weight less buoyancy",
      .help = "Spheres are heavy: along z to the front of three dimensions, along y to the bottom of two.",
      .options = GravityOptions{},
      .keys = {{.name = "acceleration",
                .place = place<&GravityOptions::acceleration>,
                .unit = "m/s^2",
                .range = ranges::not_negative,
                .help = "of free fall"},
               {.name = "fluid_density",
                .place = place<&GravityOptions::fluid_density>,
                .unit = "kg/m^3",
                .range = ranges::not_negative,
                .help = "of the fluid, whose weight in their place buoys them up"}},
      .dimensions = {2, 3},
      .periodic = true,
      .make = [](const Scene& scene) -> std::unique_ptr<Effect> { return std::make_unique<Gravity>(scene); }};
  return kind;
}

Gravity::Gravity(const Scene& scene) {
  const GravityOptions& options = *scene.effects.find<GravityOptions>();
  pull_ = (scene.material.density - options.fluid_density) * options.acceleration;
}

void Gravity::add_forces(const State& state, std::span<double> force) const {
  const Bodies& bodies = state.bodies;
  for (int i = 0; i < bodies.size(); ++i) {
    const int down = (i + 1) * bodies.dimension - 1;  // the last component
    force[down] -= pull_ * 4.0 / 3.0 * std::numbers::pi * std::pow(bodies.radius[i], 3);
  }
}

}  // namespace lichtenberg::effects
