#include "src/effects/flat_walls.hpp"

#include <fmt/format.h>

#include <cmath>

#include "src/effects/friction.hpp"
#include "src/effects/linear_contact.hpp"
#include "src/effects/surface_effect.hpp"
#include "src/effects/viscoelastic_contact.hpp"

namespace lichtenberg::effects {
namespace {

std::string key_of_walls(const std::string& key) { return "effects.flat_walls." + key; }

/// Throws InputError for keys that do not belong to the contact law of the grains.
void check_law_of_walls(const Draft& draft) {
  const auto& options = *draft.scene.effects.find<FlatWallsOptions>();
  if (!draft.scene.effects.has<LinearContactOptions>())
    refuse_if_given(
        draft, key_of_walls("restitution"),
        "needs the table [effects.linear_contact], with which it does not depend on the speed: give damping "
        "instead");
  if (options.restitution)
    refuse_if_given(draft, key_of_walls("damping"), "is given, and so is restitution: leave one of the two out");
  const auto* soft = draft.scene.effects.find<ViscoelasticContactOptions>();
  const bool some = options.young || options.poisson || options.viscosity;
  if (some && !(soft && soft->young))
    refuse(draft.scene.path, draft.line("effects.flat_walls"),
           "effects.flat_walls has young, poisson or viscosity in SI, but effects.viscoelastic_contact does not: give "
           "them there too, or stiffness and damping here");
  for (const char* reduced : {"stiffness", "damping"})
    if (some)
      refuse_if_given(draft, key_of_walls(reduced),
                      "is given, and so are young, poisson or viscosity in SI, from which it follows: leave one of the "
                      "two out");
  for (const auto& [key, value] :
       {std::pair{"young", options.young}, {"poisson", options.poisson}, {"viscosity", options.viscosity}})
    if (some && !value)
      refuse(draft.scene.path, draft.line("effects.flat_walls"),
             fmt::format("{} is missing: young, poisson and viscosity are given together, or none of them",
                         key_of_walls(key)));
  if (options.friction && !draft.scene.effects.has<FrictionOptions>())
    refuse(draft.scene.path, draft.line(key_of_walls("friction")),
           "effects.flat_walls.friction needs the table [effects.friction]: add it, or leave the key out");
}

void check_sides_of_walls(const Draft& draft) {
  if (draft.scene.domain.open)
    refuse(draft.scene.path, draft.line("effects.flat_walls"),
           "effects.flat_walls is not allowed with domain.unbounded = true, which has no sides: leave one out");
  bool any = false;
  for (int s = 0; s < 2 * draft.scene.dimension(); ++s) any |= !draft.scene.domain.sides[s].periodic;
  if (!any)
    refuse(draft.scene.path, draft.line("effects.flat_walls"),
           "effects.flat_walls needs a side of the domain that is not periodic: all are");
}

/// Computes the constants of the contact with a wall from the materials in SI. The moduli add like springs in series,
/// 1/E* = (1 - nu_1^2)/Y_1 + (1 - nu_2^2)/Y_2, and the damping is that of both dissipations in series.
void set_constants_of_walls(const Draft&, Scene& scene) {
  auto& options = *scene.effects.find<FlatWallsOptions>();
  if (options.young && scene.reference) {
    const auto& grains = *scene.effects.find<ViscoelasticContactOptions>();
    const auto [d0, m0, v0, q0] = *scene.reference;
    const double grain = (1 - *grains.poisson * *grains.poisson) / *grains.young;
    const double wall = (1 - *options.poisson * *options.poisson) / *options.young;
    options.stiffness = grains.elastic * 2 * grain / (grain + wall);
    const double time = (*grains.viscosity * grain + *options.viscosity * wall) / (grain + wall);
    options.damping = time * v0 / d0 * *options.stiffness;
  }
  if (const auto* linear = scene.effects.find<LinearContactOptions>(); linear && options.restitution)
    options.damping = linear_damping(options.stiffness.value_or(linear->stiffness), *options.restitution, 1);
}

std::vector<Key> wall_keys() {
  return {
      {.name = "stiffness",
       .target = target<&FlatWallsOptions::stiffness>,
       .range = {.low = 1e-100, .high = 1e100},
       .computed_default = "that of two grains",
       .help = "stiffness of the contact of a grain and a wall, with the meaning of the key of the same name of the "
               "grains' contact law; a wall counts as a grain of infinite radius and mass",
       .scale = Key::Scale::reduced},
      {.name = "damping",
       .target = target<&FlatWallsOptions::damping>,
       .range = ranges::not_negative,
       .computed_default = "that of two grains",
       .help = "damping of the contact of a grain and a wall, with the meaning of the key of the same name of the "
               "grains' contact law; 0: elastic",
       .scale = Key::Scale::reduced},
      {.name = "restitution",
       .target = target<&FlatWallsOptions::restitution>,
       .range = {.low = 0, .high = 1, .low_itself = false},
       .computed_default = "from damping",
       .help = "restitution coefficient of a grain of mass m0 at a wall, with [effects.linear_contact]"},
      {.name = "friction",
       .target = target<&FlatWallsOptions::friction>,
       .range = ranges::not_negative,
       .computed_default = "that of two grains",
       .help = "coefficient of friction of a grain and a wall"},
      {.name = "young",
       .target = target<&FlatWallsOptions::young>,
       .unit = "Pa",
       .range = ranges::positive,
       .computed_default = "none",
       .help = "Young's modulus of the walls in SI, in Pa. Give it with poisson and viscosity instead of stiffness "
               "and damping",
       .scale = Key::Scale::si},
      {.name = "poisson",
       .target = target<&FlatWallsOptions::poisson>,
       .range = {.low = -1, .high = 0.5, .low_itself = false},
       .computed_default = "none",
       .help = "Poisson's ratio of the walls; give it with young and viscosity"},
      {.name = "viscosity",
       .target = target<&FlatWallsOptions::viscosity>,
       .unit = "s",
       .range = ranges::not_negative,
       .computed_default = "none",
       .help = "viscous time of the walls' material in SI, in s",
       .scale = Key::Scale::si}};
}

}  // namespace

const EffectKind& FlatWallsOptions::kind() {
  static const EffectKind kind = {.name = "flat_walls",
                                  .description = "flat walls at the sides of the domain of grains",
                                  .help =
                                      "Sides of the domain that are not periodic are flat walls. The contact of a "
                                      "grain and a wall has the law of two "
                                      "grains, with the effective radius and mass of the grain and its own constants.",
                                  .options = FlatWallsOptions{},
                                  .keys = wall_keys(),
                                  .dimensions = {2, 3},
                                  .periodic = true,
                                  .grains = true,
                                  .check =
                                      [](const Draft& draft) {
                                        check_sides_of_walls(draft);
                                        check_law_of_walls(draft);
                                      },
                                  .complete = set_constants_of_walls,
                                  .make =
                                      [](const Scene& scene) {
                                        const auto& options = *scene.effects.find<FlatWallsOptions>();
                                        const WallContact contact{options.stiffness, options.damping, options.friction};
                                        return std::make_unique<SurfaceEffect>(
                                            FlatWallsOptions::kind(),
                                            [contact](SurfaceLaw& surface) { surface.walls = contact; });
                                      },
                                  .device = [](const Scene&, DeviceForces&) {}};
  return kind;
}

}  // namespace lichtenberg::effects
