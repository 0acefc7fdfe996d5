#include "src/effects/contact_resistance.hpp"

#include <fmt/format.h>

namespace lichtenberg::effects {
namespace {

void check_contact_resistance(const Draft& draft) {
  const ContactResistanceOptions& options = *draft.scene.effects.find<ContactResistanceOptions>();
  const std::string name = options.kind().name;
  if (options.resistivity > 0 && options.contact_radius == 0)
    refuse_effect(draft, name, "a contact_radius in m, greater than 0, in addition to its resistivity");
  if (options.resistivity == 0)
    refuse_if_given(
        draft, "effects.contact_resistance.contact_radius",
        "needs effects.contact_resistance.resistivity in ohm m, greater than 0: add it, or leave the radius out");
  if (options.ohms() == 0) refuse_effect(draft, name, "a resistance in ohm or a resistivity in ohm m, greater than 0");
}

}  // namespace

const EffectKind& ContactResistanceOptions::kind() {
  static const EffectKind kind = {
      .name = "contact_resistance",
      .description = "a contact is a resistor between two conductors; charge moves in implicit steps with the field",
      .help =
          "A contact is a resistor instead of a connection: resistance + resistivity / (2 contact_radius), after Holm. "
          "Needs contact_discharge, which defines contacts.",
      .options = ContactResistanceOptions{},
      .keys = {{.name = "resistance",
                .target = target<&ContactResistanceOptions::resistance>,
                .unit = "ohm",
                .range = ranges::not_negative,
                .help = "constant part of the resistance of one contact, in ohm"},
               {.name = "resistivity",
                .target = target<&ContactResistanceOptions::resistivity>,
                .unit = "ohm m",
                .range = ranges::not_negative,
                .help = "resistivity of the conductors, in ohm m; adds Holm's constriction resistance, resistivity / "
                        "(2 contact_radius), to each contact, and needs contact_radius"},
               {.name = "contact_radius",
                .target = target<&ContactResistanceOptions::contact_radius>,
                .unit = "m",
                .range = ranges::not_negative,
                .help = "radius of the contact area between two conductors, in m; needs resistivity",
                .old_name = "spot"}},
      .needs = {{"contact_discharge", "which defines contacts"}},
      .dimensions = {2, 3},
      .periodic = true,
      .check = check_contact_resistance,
      .make = [](const Scene&) { return std::make_unique<ContactResistance>(); },
      .explain = [](const Scene& scene) -> std::vector<ExplanationLine> {
        return {{"a contact", fmt::format("{:.4g} ohm", scene.effects.find<ContactResistanceOptions>()->ohms())}};
      },
      .sharing = [](const Scene& scene, Contact) -> SharingLaw {
        return {.conductance = 1 / scene.effects.find<ContactResistanceOptions>()->ohms()};
      },
      .energy_advice =
          "conductors are pressed together before they share their charge, unless a contact's resistance times its "
          "capacitance is less than the time to cross its gap: lower the resistance in [effects.contact_resistance] "
          "or widen effects.contact_discharge.contact_distance"};
  return kind;
}

}  // namespace lichtenberg::effects
