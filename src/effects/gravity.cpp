#include "src/effects/gravity.hpp"

#include <cmath>
#include <numbers>
#include <string>

#include "src/effects/vector_key.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::effects {
namespace {

void check_gravity(const Draft& draft) {
  const auto& direction = draft.scene.effects.find<GravityOptions>()->direction;
  if (!direction) return;
  const auto refuse_it = [&](const std::string& sentence) {
    refuse(draft.scene.path, draft.line("effects.gravity.direction"), "effects.gravity.direction " + sentence);
  };
  check_components(draft, "effects.gravity.direction", *direction);
  const double length = norm(direction->value);
  if (!(length > 0) || !std::isfinite(length)) refuse_it("must have a length greater than 0 that is a finite number");
}

/// Calls visit(k, component) for each axis along which bodies fall.
template <class Visit>
void for_each_axis(Vec3 down, int dimension, const Visit& visit) {
  for (int k = 0; k < dimension; ++k)
    if (down[k] != 0) visit(k, down[k]);
}

}  // namespace

Vec3 down(const GravityOptions& options, const Domain& domain) {
  if (options.direction) return options.direction->value / norm(options.direction->value);
  Vec3 last{};
  last[domain.dimension() - 1] = -1;
  return last;
}

const EffectKind& GravityOptions::kind() {
  static const EffectKind kind = {
      .name = "gravity",
      .description = "weight less buoyancy",
      .help =
          "Weight of the spheres minus their buoyancy, along direction. Its default is -z in three dimensions, toward "
          "the front side z = 0, because the sides bottom and top lie along y, and -y in two, toward the bottom side. "
          "Along a periodic axis the potential energy is that of the unwrapped position.",
      .options = GravityOptions{},
      .keys = {{.name = "acceleration",
                .target = target<&GravityOptions::acceleration>,
                .unit = "m/s^2",
                .range = ranges::not_negative,
                .help = "acceleration of free fall, in m/s^2"},
               {.name = "direction",
                .target = target<&GravityOptions::direction>,
                .range = {.low = -1e100, .high = 1e100},  // squares must not overflow
                .computed_default = "[0, 0, -1] in three dimensions, to the front; [0, -1] in two, to the bottom",
                .help = "direction of free fall, a vector of any length but 0; in pictures in perspective the "
                        "axis nearest to it points down"},
               {.name = "fluid_density",
                .target = target<&GravityOptions::fluid_density>,
                .unit = "kg/m^3",
                .range = ranges::not_negative,
                .help =
                    "density of the fluid, in kg/m^3, from which the buoyancy of the spheres follows; 0: no buoyancy"}},
      .dimensions = {2, 3},
      .periodic = true,
      .check = check_gravity,
      .make = [](const Scene& scene) { return std::make_unique<Gravity>(scene); }};
  return kind;
}

Gravity::Gravity(const Scene& scene) {
  const GravityOptions& options = *scene.effects.find<GravityOptions>();
  weight_density_ = (scene.material.density - options.fluid_density) * options.acceleration;
  down_ = down(options, scene.domain);
}

void Gravity::add_forces(const State& state, std::span<double> force) const {
  const Bodies& bodies = state.bodies;
  const int d = bodies.dimension;
  for_each_requested(state, [&](int i) {
    for_each_axis(down_, d, [&](int k, double part) { force[i * d + k] += weight(bodies.radius[i]) * part; });
  });
}

double Gravity::stored_energy(const State& state) const {
  const Bodies& bodies = state.bodies;
  const int d = bodies.dimension;
  double energy = 0;
  for (int i = 0; i < bodies.size(); ++i)
    for_each_axis(down_, d, [&](int k, double part) {
      double coordinate = bodies.position[i * d + k];
      if (!bodies.image.empty()) coordinate += bodies.image[i * d + k] * bodies.box.lengths[k];
      energy -= weight(bodies.radius[i]) * part * coordinate;
    });
  return energy;
}

double Gravity::weight(double radius) const {
  return weight_density_ * 4.0 / 3.0 * std::numbers::pi * std::pow(radius, 3);
}

}  // namespace lichtenberg::effects
