#include "src/effects/stokes_drag.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "src/scene/scene.hpp"

namespace lichtenberg::effects {
namespace {

constexpr double usual_roughness = 1e-3;  // of a radius

/// Returns for each side of the domain whether it is a wall for the fluid.
std::array<bool, 6> walls_of(const Domain& domain) {
  std::array<bool, 6> walls{};
  for (int s = 0; s < 2 * domain.dimension(); ++s) walls[s] = !domain.open && !domain.sides[s].periodic;
  return walls;
}

void check_stokes_drag(const Draft& draft) {
  if (!draft.viscosity) refuse_effect(draft, "stokes_drag", "medium.viscosity in Pa s");
  const StokesDragOptions& options = *draft.scene.effects.find<StokesDragOptions>();
  if (options.roughness && !options.walls)
    refuse_if_given(draft, "effects.stokes_drag.roughness",
                    "needs effects.stokes_drag.walls = true: add it, or leave the roughness out");
}

void complete_stokes_drag(const Draft& draft, Scene& scene) {
  const StokesDragOptions& options = *scene.effects.find<StokesDragOptions>();
  if (!options.walls) return;
  const auto refuse_it = [&](const std::string& key, const std::string& message) {
    refuse(draft.scene.path, draft.line("effects.stokes_drag." + key), "effects.stokes_drag." + key + message);
  };
  if (std::ranges::none_of(walls_of(scene.domain), [](bool wall) { return wall; }))
    refuse_it("walls", " = true needs a side of the domain that is not periodic, and the domain has none");
  double largest = 0;
  for (const Conductor& conductor : scene.conductors) largest = std::max(largest, conductor.radius);
  if (options.roughness && *options.roughness < WallDrag::least_gap * largest)
    refuse_it("roughness", fmt::format(" = {:g} is not allowed: it must be at least {:g} of the largest radius, {:g} m",
                                       *options.roughness, WallDrag::least_gap, WallDrag::least_gap * largest));
}

std::vector<ExplanationLine> explain_stokes_drag(const Scene& scene) {
  const StokesDragOptions& options = *scene.effects.find<StokesDragOptions>();
  if (!options.walls || scene.conductors.empty()) return {};
  const double radius = scene.smallest_radius(), roughness = options.roughness.value_or(usual_roughness * radius);
  const WallDrag::Factors rough = WallDrag().at(roughness / radius);
  return {{"near a side", fmt::format("Stokes's drag times up to {:.4g} towards it and {:.3g} along it, at {:.3g} m",
                                      rough.towards, rough.along, roughness)}};
}

}  // namespace

const EffectKind& StokesDragOptions::kind() {
  static const EffectKind kind = {
      .name = "stokes_drag",
      .description = "drag of spheres in a viscous fluid",
      .help =
          "Drag of a sphere of radius R and velocity v in the fluid by Stokes's law, F = -6 pi viscosity R v "
          "(Stephenson 2018, eq. 5.8). Needs medium.viscosity.",
      .options = StokesDragOptions{},
      .keys = {{.name = "walls",
                .target = target<&StokesDragOptions::walls>,
                .help = "true: drag grows near the sides of the domain that are not periodic, by the factors of a "
                        "plane wall for motion towards it (Brenner 1961) and along it (O'Neill 1964); several sides "
                        "add up. Electrodes in the domain and other spheres do not count"},
               {.name = "roughness",
                .target = target<&StokesDragOptions::roughness>,
                .unit = "m",
                .range = ranges::positive,
                .computed_default = "1e-3 of each radius",
                .help = "with walls: gap in m below which the drag stays constant, as between rough surfaces; between "
                        "smooth surfaces it has no limit. At least 1e-4 of the largest radius"}},
      .dimensions = {2, 3},
      .periodic = true,
      .check = check_stokes_drag,
      .complete = complete_stokes_drag,
      .make = [](const Scene& scene) { return std::make_unique<StokesDrag>(scene); },
      .explain = explain_stokes_drag};
  return kind;
}

StokesDrag::StokesDrag(const Scene& scene) : viscosity_(scene.medium.viscosity) {
  const auto* options = scene.effects.find<StokesDragOptions>();
  if (options && options->walls)
    walls_ = std::make_shared<const Walls>(Walls{scene.domain.size, walls_of(scene.domain), options->roughness, {}});
}

DragLaw StokesDrag::drag(const Bodies& bodies, int body) const {
  const double radius = bodies.radius[body];
  DragLaw law{.linear = 6 * std::numbers::pi * viscosity_ * radius};
  if (!walls_) return law;
  law.by_position = [walls = walls_, radius, stokes = law.linear](Vec3 position) {
    const double least = walls->roughness.value_or(usual_roughness * radius);
    Vec3 more{};
    for (int s = 0; s < 6; ++s) {
      if (!walls->is_wall[s]) continue;
      const int axis = s / 2;
      const double distance = s % 2 == 0 ? position[axis] : walls->size[axis] - position[axis];
      const auto [towards, along] = walls->factors.at(std::max(distance - radius, least) / radius);
      for (int k = 0; k < 3; ++k) more[k] += stokes * ((k == axis ? towards : along) - 1);
    }
    return more;
  };
  return law;
}

}  // namespace lichtenberg::effects
