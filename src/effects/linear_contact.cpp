#include "src/effects/linear_contact.hpp"

#include "src/effects/grain_contact_effect.hpp"
#include "src/scene/si.hpp"

namespace lichtenberg::effects {

LinearSpringLaw linear_law(const LinearContactOptions& options) {
  constexpr double effective_mass = 0.5;  // effective mass of two grains of mass 1
  if (options.damping) return {options.stiffness, *options.damping};
  return {options.stiffness, linear_damping(options.stiffness, options.restitution.value_or(0.9), effective_mass)};
}

const EffectKind& LinearContactOptions::kind() {
  static const EffectKind kind = {
      .name = "linear_contact",
      .description = "linear spring and dashpot between grains",
      .help =
          "Grains in contact repel each other by the linear force F = max(A overlap + B d overlap/dt, 0) (Singh 2019, "
          "equations 3.6 and 3.9), whose restitution coefficient does not depend on the speed.",
      .options = LinearContactOptions{},
      .keys = {{.name = "stiffness",
                .target = target<&LinearContactOptions::stiffness>,
                .unit = "m0/t0^2",
                .range = ranges::positive,
                .help = "stiffness A of the spring in the contact force max(A overlap + B d overlap/dt, 0), in reduced "
                        "units (m0 / t0^2)"},
               {.name = "restitution",
                .target = target<&LinearContactOptions::restitution>,
                .range = {.low = 0, .high = 1, .low_itself = false},
                .computed_default = "0.9, unless damping is given",
                .help = "restitution coefficient of two grains of the unit mass m0 in a collision, from which the "
                        "damping B of the contact force follows"},
               {.name = "damping",
                .target = target<&LinearContactOptions::damping>,
                .unit = "m0/t0",
                .range = ranges::not_negative,
                .computed_default = "from restitution",
                .help = "damping B of the dashpot in the contact force max(A overlap + B d overlap/dt, 0), in reduced "
                        "units (m0 / t0); give it instead of restitution"}},
      .dimensions = {2, 3},
      .periodic = true,
      .grains = true,
      .check =
          [](const Draft& draft) {
            const auto& options = *draft.scene.effects.find<LinearContactOptions>();
            require_in_si(draft, "effects.linear_contact.stiffness");
            if (options.restitution && options.damping)
              refuse(draft.scene.path, draft.line("effects.linear_contact.damping"),
                     "effects.linear_contact.damping and effects.linear_contact.restitution are both given: only one "
                     "of them is allowed");
          },
      .make =
          [](const Scene& scene) {
            return std::make_unique<GrainContactEffect>(LinearContactOptions::kind(),
                                                        linear_law(*scene.effects.find<LinearContactOptions>()));
          },
      .device = contact_on_device};
  return kind;
}

}  // namespace lichtenberg::effects
