#include "src/commands/cost.hpp"

#include <cmath>

namespace lichtenberg {

FieldCost estimate_field_cost(const FieldOptions&, double cells) {
  return {45e6 + 100 * cells, 0.15e-6 * cells, 0.08e-6 * cells};
}

std::optional<double> estimate_field_solves(const Scene& scene) {
  if (scene.mechanics.integrator == "euler") return scene.stop.time / scene.mechanics.euler_field_step;
  const Effects& effects = scene.effects;
  if (!effects.current_source || !effects.stokes_drag || !effects.contact_discharge) return std::nullopt;
  const double n = static_cast<double>(scene.conductors.size());
  return 0.18 * n * n;
}

}  // namespace lichtenberg
