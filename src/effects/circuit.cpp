#include "src/effects/circuit.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "solvers/error.hpp"
#include "src/effects/contact_discharge.hpp"
#include "src/effects/leakage.hpp"
#include "src/field_methods/field_method.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

namespace {

/// Throws InputError for a capacitor in a scene whose field method or fluid does not allow it.
void check_capacitors(const Draft& draft) {
  const Scene& scene = draft.scene;
  if (std::ranges::none_of(scene.circuits, [](const Circuit& circuit) { return circuit.capacitance > 0; })) return;
  if (scene.effects.has<LeakageOptions>())
    refuse(scene.path, draft.line("circuit.capacitance"),
           "circuit.capacitance is not allowed with [effects.leakage], which would discharge the capacitor as well: "
           "leave one of the two out");
  if (draft.domain_size.count == 2 && draft.field.method && !draft.field.method->couplings)
    refuse(scene.path, draft.line("field.method"),
           fmt::format("field.method = \"{}\" is not allowed with circuit.capacitance: it must be {}",
                       draft.field.method->name,
                       field_methods_that(2, [](const FieldMethodKind& method) { return method.couplings; })));
}

}  // namespace

void check_resistors(const Draft& draft) {
  const Scene& scene = draft.scene;
  const bool electrode =
      std::ranges::any_of(draft.electrodes, [](const auto& e) { return e.series_resistance.has_value(); });
  const bool circuit = std::ranges::any_of(scene.circuits, [](const auto& c) { return c.resistance > 0; });
  const bool series = electrode || circuit;
  check_sharing(scene);
  check_capacitors(draft);
  const EffectKind* sharing = sharing_effect(scene);
  if (!series && !sharing) return;
  const std::string what = electrode ? "electrode.series_resistance"
                           : circuit ? "a circuit with a resistance"
                                     : fmt::format("the table [effects.{}]", sharing->name);
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
                       "cannot reach for charge through resistors: use \"cvode\", or leave field.accuracy out",
                       integrator.name, what));
}

void check_sharing(const Scene& scene) {
  const EffectKind* first = sharing_effect(scene);
  if (!first) return;
  if (first->grains)
    throw InputError(
        fmt::format("{}: effects.{} defines EffectKind::sharing, which is not for grains: it must define "
                    "Effect::exchange_charges instead",
                    scene.path, first->name));
  if (!scene.effects.has<ContactDischargeOptions>())
    throw InputError(
        fmt::format("{}: effects.{} needs the table [effects.contact_discharge], which defines contacts: add it, or "
                    "leave the effect out",
                    scene.path, first->name));
  for (const Effects::Entry& effect : scene.effects)
    if (effect.kind->sharing && effect.kind != first)
      throw InputError(fmt::format("{}: effects.{} and effects.{} both define how contacts share charge: leave one out",
                                   scene.path, first->name, effect.kind->name));
}

bool has_resistors(const Scene& scene) {
  return sharing_effect(scene) ||
         std::ranges::any_of(scene.electrodes, [](const Electrode& e) { return e.series_resistance > 0; }) ||
         std::ranges::any_of(scene.circuits, [](const Circuit& circuit) { return circuit.resistance > 0; });
}

bool has_circuit(const Scene& scene) {
  std::vector<PotentialSource> supplies = potential_sources_of(scene);
  std::erase_if(supplies, [](const PotentialSource& supply) { return !supply.is_source; });
  const bool difference = std::ranges::any_of(supplies, [&](const PotentialSource& supply) {
    return supply.potential.varies() || !(supply.potential == supplies.front().potential);
  });
  const bool fed = std::ranges::any_of(
      scene.circuits, [](const Circuit& circuit) { return circuit.current || circuit.capacitance > 0; });
  return scene.effects.has(&EffectKind::field) &&
         (difference || fed || scene.effects.has<LeakageOptions>() || has_resistors(scene));
}

std::vector<Resistor> resistors_of(const Scene& scene, std::span<const Contact> contacts) {
  const std::vector<Terminal> terminals = terminals_of(scene);
  std::vector<Resistor> resistors;
  for (const auto& [node, supply, circuit] : circuit_nodes(scene))
    if (circuit.resistance > 0)
      resistors.push_back({.a = node,
                           .supply = supply,
                           .potential = circuit.potential.value,
                           .conductance = 1 / circuit.resistance,
                           .series = true});
  if (!sharing_effect(scene)) return resistors;
  const int n = static_cast<int>(scene.conductors.size());
  for (const Contact& contact : contacts) {
    const SharingLaw law = sharing_law(scene, contact);
    if (law.joins()) continue;
    Resistor resistor{.a = contact.conductor,
                      .conductance = law.conductance,
                      .partner = contact.partner,
                      .depends_on_state = law.conductance_in_state != nullptr};
    if (resistor.depends_on_state) resistor.conductance = 0;
    if (contact.partner < n)
      resistor.b = contact.partner;
    else if (const int node = terminals[contact.partner - n].node; node >= 0)
      resistor.b = node;
    else
      resistor.supply = contact.partner - n, resistor.potential = terminals[resistor.supply].potential.value;
    resistors.push_back(resistor);
  }
  return resistors;
}

namespace {

/// Returns the conductance (S) of a contact whose conductance depends on its state (voltage and gap). Throws the
/// exceptions of contact_current().
double contact_conductance(const Scene& scene, Contact contact, ContactState state) {
  const SharingLaw law = sharing_law(scene, contact);
  if (!(law.gap_scale > 0))
    throw InputError(fmt::format("{}: effects.{} gives a law of charge sharing a gap_scale of {:g} m: it must be > 0",
                                 scene.path, sharing_effect(scene)->name, law.gap_scale));
  const std::optional<double> gap = std::exchange(state.known_gap, {});
  if (std::isfinite(law.gap_scale)) state.known_gap = gap;
  const double conductance = law.conductance_in_state(state);
  if (conductance >= 0 && std::isfinite(conductance)) return conductance;
  throw InputError(
      fmt::format("{}: effects.{} gives a contact a conductance of {:g} S at a gap of {:g} m and {:g} V: a law that "
                  "depends on the state must give a finite value of at least 0",
                  scene.path, sharing_effect(scene)->name, conductance, gap.value_or(NAN), state.potential_difference));
}

}  // namespace

double contact_current(const Scene& scene, Contact contact, const ContactState& state) {
  return contact_conductance(scene, contact, state) * state.potential_difference;
}

void linearize(const Scene& scene, Contact contact, const ContactState& state, Resistor& resistor) {
  const auto current_at = [&](double potential_difference) {
    return contact_current(scene, contact, {potential_difference, state.known_gap});
  };
  // The difference changes in relative steps that keep its sign, because a law may have a kink at 0.
  const double difference = state.potential_difference, step = 1e-4 * difference, current = current_at(difference);
  if (difference == 0) {
    resistor.conductance = contact_conductance(scene, contact, state);
  } else {
    const double slope = (current_at(difference + step) - current_at(difference - step)) / (2 * step);
    resistor.conductance = std::max(slope, 0.0);
  }
  resistor.source = current - resistor.conductance * difference;
}

ChargeStep charge_step(double dt, double before, double relaxation_time) {
  const double ratio = before > 0 ? dt / before : 0;
  const double inherited = ratio * ratio / (1 + 2 * ratio);
  const auto filled = [&](double time) {  // integral of exp(-s/tau) from 0 to time
    return std::isfinite(relaxation_time) ? -relaxation_time * std::expm1(-time / relaxation_time) : time;
  };
  const double decay = std::exp(-dt / relaxation_time);
  return {.decay = decay,
          .injection_time = filled(dt),
          .weight = filled(dt) - inherited * decay * filled(before),
          .inherited = inherited * decay,
          .total_weight = dt - inherited * before,
          .total_inherited = inherited};
}

double charge_error(double carried, double dt, double at_start, double at_end, double noise) {
  at_start += std::clamp(at_end - at_start, -noise, noise);
  const double ratio = at_start == 0 ? 1 : at_end / at_start;
  if (!(ratio > 0 && ratio < 1)) return std::abs(carried - 0.5 * dt * (at_start + at_end));
  const double z = 1 / ratio - 1;
  return std::abs(carried + at_start * dt * std::expm1(-z) / z);
}

}  // namespace lichtenberg::effects
