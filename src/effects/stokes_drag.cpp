#include "src/effects/stokes_drag.hpp"

#include <numbers>

namespace lichtenberg::effects {

const EffectKind& StokesDragOptions::kind() {
  static const EffectKind kind = {
      .name = "stokes_drag",
      .description = "drag of spheres in a viscous fluid",
      .help =
          "Drag of a sphere of radius R and velocity v in the fluid by Stokes's law, F = -6 pi viscosity R v "
          "(Stephenson 2018, eq. 5.8). Needs medium.viscosity.",
      .options = StokesDragOptions{},
      .dimensions = {2, 3},
      .periodic = true,
      .check =
          [](const Draft& draft) {
            if (!draft.viscosity) refuse_effect(draft, "stokes_drag", "medium.viscosity in Pa s");
          },
      .make = [](const Scene& scene) { return std::make_unique<StokesDrag>(scene.medium.viscosity); }};
  return kind;
}

DragLaw StokesDrag::drag(const Bodies& bodies, int body) const {
  return {.linear = 6 * std::numbers::pi * viscosity_ * bodies.radius[body]};
}

}  // namespace lichtenberg::effects
