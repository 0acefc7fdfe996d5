#include "src/analysis/power.hpp"

#include <algorithm>

#include "src/effects/effects.hpp"

namespace lichtenberg::analysis {
namespace {

bool all_at_zero(const Scene& scene) {
  const auto has_potential = [](const auto& holder) { return holder.potential != 0; };
  return std::ranges::none_of(scene.electrodes, has_potential) &&
         std::ranges::none_of(scene.domain.sides,
                              [](const DomainSide& side) { return side.electrode && side.potential != 0; }) &&
         std::ranges::none_of(scene.groups,
                              [](const PrescribedGroup& group) { return group.potential.value_or(0) != 0; });
}

/// Returns the scene at a frame's instant without a field solver, because the frame has the field's results.
Model model_at(const Scene& scene, const ConductorFrame& frame) {
  Scene now = scene;
  for (std::size_t i = 0; i < frame.position.size(); ++i) now.conductors[i].position = frame.position[i];
  return effects::make_model_without_field(now);
}

}  // namespace

Power power(const Scene& scene, const ConductorFrame& frame, std::span<const double> mass) {
  Model model = model_at(scene, frame);
  std::vector<double> current(model.bodies.size());
  model.currents(frame.time, current);
  Power result;
  for (std::size_t i = 0; i < frame.potential.size(); ++i) result.source += current[i] * frame.potential[i];
  for (std::size_t i = 0; i < frame.velocity.size(); ++i) {
    result.drag += model.drag.power(static_cast<int>(i), frame.position[i], frame.velocity[i]);
    result.field += dot(frame.force[i], frame.velocity[i]);
    result.kinetic += 0.5 * mass[i] * norm2(frame.velocity[i]);
  }
  result.elastic = model.stored_energy(frame.time);
  return result;
}

std::optional<double> dissipated_power(const Scene& scene, const ConductorFrame& before, const Power& power_before,
                                       const ConductorFrame& after, const Power& power_after) {
  const double dt = after.time - before.time;
  if (!(dt > 0) || !all_at_zero(scene)) return {};
  const double stored = after.energy - before.energy + power_after.kinetic - power_before.kinetic +
                        power_after.elastic - power_before.elastic;
  return 0.5 * (power_before.source + power_after.source) - stored / dt;
}

}  // namespace lichtenberg::analysis
