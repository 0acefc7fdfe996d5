#include "src/effects/circuit.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "src/effects/contact_resistance.hpp"
#include "src/effects/leakage.hpp"
#include "src/field_methods/field_method.hpp"

namespace lichtenberg::effects {

void check_resistors(const Draft& draft) {
  const Scene& scene = draft.scene;
  const bool series =
      std::ranges::any_of(draft.electrodes, [](const auto& e) { return e.series_resistance.has_value(); });
  if (!series && !scene.effects.has<ContactResistanceOptions>()) return;
  const std::string what = series ? "electrode.series_resistance" : "the table [effects.contact_resistance]";
  const auto refuse_with = [&](const std::string& key, const std::string& value, const std::string& allowed) {
    refuse(scene.path, draft.line(key),
           fmt::format("{} = \"{}\" is not allowed with {}: it must be {}", key, value, what, allowed));
  };
  if (draft.domain_size.count == 2 && draft.field.method && !draft.field.method->couplings)
    refuse_with("field.method", draft.field.method->name,
                field_methods_that(2, [](const FieldMethodKind& method) { return method.couplings; }));
  const IntegratorKind& integrator = scene.mechanics.kind();
  if (!integrator.carries_resistors && &integrator == scene.mechanics.integrator->monolithic)
    refuse_with("mechanics.coupling", "monolithic", "\"split\"");
  if (!integrator.carries_resistors)
    refuse_with("mechanics.integrator", name_of(scene.mechanics.integrator), "\"cvode\"");
  if (!integrator.reads("position_tolerance") && draft.field.accuracy)
    refuse(scene.path, draft.line("mechanics.integrator"),
           fmt::format("mechanics.integrator = \"{}\" is not allowed with {} and field.accuracy, which its steps "
                       "cannot keep for what resistors carry: take \"cvode\", or leave field.accuracy out",
                       integrator.name, what));
}

bool has_resistors(const Scene& scene) {
  return scene.effects.has<ContactResistanceOptions>() ||
         std::ranges::any_of(scene.electrodes, [](const Electrode& e) { return e.series_resistance > 0; });
}

bool has_circuit(const Scene& scene) {
  const std::vector<Supply> supplies = supplies_of(scene);
  const bool difference = std::ranges::any_of(
      supplies, [&](const Supply& supply) { return supply.potential != supplies.front().potential; });
  return scene.effects.has(&EffectKind::field) &&
         (difference || scene.effects.has<LeakageOptions>() || has_resistors(scene));
}

std::vector<Resistor> resistors_of(const Scene& scene, std::span<const Contact> contacts) {
  const std::vector<Terminal> terminals = terminals_of(scene);
  std::vector<Resistor> resistors;
  for (int t = 0; t < static_cast<int>(terminals.size()); ++t)
    if (terminals[t].node >= 0)
      resistors.push_back({.a = terminals[t].node,
                           .supply = t,
                           .potential = terminals[t].potential,
                           .conductance = 1 / terminals[t].series_resistance,
                           .series = true});
  if (!scene.effects.has<ContactResistanceOptions>()) return resistors;
  const double conductance = 1 / scene.effects.find<ContactResistanceOptions>()->ohms();
  const int n = static_cast<int>(scene.conductors.size());
  for (const Contact& contact : contacts) {
    Resistor resistor{.a = contact.conductor, .conductance = conductance};
    if (contact.partner < n)
      resistor.b = contact.partner;
    else if (const int node = terminals[contact.partner - n].node; node >= 0)
      resistor.b = node;
    else
      resistor.supply = contact.partner - n, resistor.potential = terminals[resistor.supply].potential;
    resistors.push_back(resistor);
  }
  return resistors;
}

ChargeStep charge_step(double dt, double before, double relaxation_time) {
  const double ratio = before > 0 ? dt / before : 0;
  const double inherited = ratio * ratio / (1 + 2 * ratio);
  const auto filled = [&](double time) {  // integral of exp(-s/tau) from 0 to time
    return std::isfinite(relaxation_time) ? -relaxation_time * std::expm1(-time / relaxation_time) : time;
  };
  const double decay = std::exp(-dt / relaxation_time);
  return {.decay = decay,
          .fed = filled(dt),
          .weight = filled(dt) - inherited * decay * filled(before),
          .inherited = inherited * decay,
          .plain_weight = dt - inherited * before,
          .plain_inherited = inherited};
}

double charge_error(double carried, double dt, double at_start, double at_end, double noise) {
  at_start += std::clamp(at_end - at_start, -noise, noise);
  const double ratio = at_start == 0 ? 1 : at_end / at_start;
  if (!(ratio > 0 && ratio < 1)) return std::abs(carried - 0.5 * dt * (at_start + at_end));
  const double z = 1 / ratio - 1;
  return std::abs(carried + at_start * dt * std::expm1(-z) / z);
}

}  // namespace lichtenberg::effects
