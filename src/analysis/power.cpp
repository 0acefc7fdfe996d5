#include "src/analysis/power.hpp"

#include <algorithm>
#include <numbers>

#include "src/effects/current_source.hpp"
#include "src/effects/effects.hpp"
#include "src/effects/hertz_contact.hpp"
#include "src/effects/stokes_drag.hpp"
#include "src/effects/wall_contact.hpp"

namespace lichtenberg::analysis {
namespace {

bool all_at_zero(const Scene& scene) {
  const auto held_off_zero = [](const auto& holder) { return holder.potential != 0; };
  return std::ranges::none_of(scene.electrodes, held_off_zero) &&
         std::ranges::none_of(scene.domain.sides,
                              [](const DomainSide& side) { return side.electrode && side.potential != 0; }) &&
         std::ranges::none_of(scene.groups,
                              [](const PrescribedGroup& group) { return group.potential.value_or(0) != 0; });
}

double elastic_energy(const Scene& scene, const std::vector<Vec2>& position) {
  Scene contacts = scene;
  contacts.effects = {};
  if (const auto* spheres = scene.effects.find<effects::HertzContactOptions>()) contacts.effects.add(*spheres);
  if (const auto* walls = scene.effects.find<effects::WallContactOptions>()) contacts.effects.add(*walls);
  for (std::size_t i = 0; i < position.size(); ++i) contacts.conductors[i].position = in_space(position[i]);
  return effects::make_model(contacts).stored_energy(0);
}

}  // namespace

Power power(const Scene& scene, const ConductorFrame& frame, std::span<const double> mass) {
  const auto* source = scene.effects.find<effects::CurrentSourceOptions>();
  const double current = source ? source->current : 0;
  const double drag =
      scene.effects.has<effects::StokesDragOptions>() ? 6 * std::numbers::pi * scene.medium.viscosity : 0;
  Power result;
  for (const double potential : frame.potential) result.source += current * potential;
  for (std::size_t i = 0; i < frame.velocity.size(); ++i) {
    result.drag += drag * scene.conductors[i].radius * norm2(frame.velocity[i]);
    result.field += dot(frame.force[i], frame.velocity[i]);
    result.kinetic += 0.5 * mass[i] * norm2(frame.velocity[i]);
  }
  result.elastic = elastic_energy(scene, frame.position);
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
