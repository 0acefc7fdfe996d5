#include "src/effects/stokes_drag.hpp"

#include <numbers>

namespace lichtenberg::effects {

const EffectKind& StokesDragOptions::kind() {
  static const EffectKind kind = {
      .name = "stokes_drag",
      .description = "drag of spheres in a viscous fluid",
      .help = "Drag of a sphere in the fluid, F = -6 pi viscosity R v (D 5.8). Needs medium.viscosity.",
      .options = StokesDragOptions{},
      .dimensions = {2, 3},
      .periodic = true,
      .check =
          [](const Draft& draft) {
            if (!draft.viscosity) refuse_effect(draft, "stokes_drag", "medium.viscosity in Pa s");
          },
      .make = [](const Scene& scene) -> std::unique_ptr<Effect> {
        return std::make_unique<StokesDrag>(scene.medium.viscosity);
      }};
  return kind;
}

double StokesDrag::drag_coefficient(double radius) const { return 6 * std::numbers::pi * viscosity_ * radius; }

void StokesDrag::add_forces(const State& state, std::span<double> force) const {
  const Bodies& b = state.bodies;
  for_each_asked(state, [&](int i) {
    const double rate = drag_coefficient(b.radius[i]) / b.mass[i];
    for (int k = i * b.dimension; k < (i + 1) * b.dimension; ++k) force[k] -= rate * b.momentum[k];
  });
}

void StokesDrag::add_jacobian(const State& state, ForceJacobian& jacobian) const {
  const Bodies& b = state.bodies;
  for_each_asked(state, [&](int i) { jacobian.add_drag(i, -drag_coefficient(b.radius[i]) / b.mass[i]); });
}

}  // namespace lichtenberg::effects
