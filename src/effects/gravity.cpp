#include "src/effects/gravity.hpp"

#include <cmath>
#include <numbers>

#include "src/scene/scene.hpp"

namespace lichtenberg::effects {
namespace {

/// The place of a body's last component, along which it falls.
int height_of(const Bodies& bodies, int i) { return (i + 1) * bodies.dimension - 1; }

}  // namespace

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
  for_each_asked(state, [&](int i) { force[height_of(bodies, i)] -= pull(bodies.radius[i]); });
}

double Gravity::stored_energy(const State& state) const {
  const Bodies& bodies = state.bodies;
  double energy = 0;
  for (int i = 0; i < bodies.size(); ++i) energy += pull(bodies.radius[i]) * bodies.position[height_of(bodies, i)];
  return energy;
}

double Gravity::pull(double radius) const { return pull_ * 4.0 / 3.0 * std::numbers::pi * std::pow(radius, 3); }

}  // namespace lichtenberg::effects
