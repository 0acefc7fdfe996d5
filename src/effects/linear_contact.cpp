#include "src/effects/linear_contact.hpp"

#include "src/effects/grain_contact_effect.hpp"

namespace lichtenberg::effects {
namespace {

LinearSpringLaw law_of(const LinearContactOptions& options) {
  constexpr double effective_mass = 0.5;  // effective mass of two grains of mass 1
  if (options.damping) return {options.stiffness, *options.damping};
  return {options.stiffness, linear_damping(options.stiffness, options.restitution.value_or(0.9), effective_mass)};
}

}  // namespace

const EffectKind& LinearContactOptions::kind() {
  static const EffectKind kind = {
      .name = "linear_contact",
      .description = "linear spring and dashpot between grains",
      .help =
          "Grains in contact repel each other by F = max(A overlap + B d overlap/dt, 0) (G 3.6, 3.9), whose "
          "restitution does not depend on the speed.",
      .options = LinearContactOptions{},
      .keys = {{.name = "stiffness",
                .target = target<&LinearContactOptions::stiffness>,
                .range = ranges::positive,
                .help = "A in the force above, in m0 / t0^2"},
               {.name = "restitution",
                .target = target<&LinearContactOptions::restitution>,
                .range = {.low = 0, .high = 1, .low_itself = false},
                .computed_default = "0.9, unless damping is given",
                .help = "restitution coefficient of two grains of mass m0; determines the damping B"},
               {.name = "damping",
                .target = target<&LinearContactOptions::damping>,
                .range = ranges::not_negative,
                .computed_default = "from restitution",
                .help = "B in the force above, in m0 / t0; give it instead of restitution"}},
      .dimensions = {2, 3},
      .periodic = true,
      .grains = true,
      .check =
          [](const Draft& draft) {
            const auto& options = *draft.scene.effects.find<LinearContactOptions>();
            if (options.restitution && options.damping)
              refuse(draft.scene.path, draft.line("effects.linear_contact.damping"),
                     "effects.linear_contact.damping and effects.linear_contact.restitution are both given: only one "
                     "of them is allowed");
          },
      .make =
          [](const Scene& scene) {
            return std::make_unique<GrainContactEffect>(LinearContactOptions::kind(),
                                                        law_of(*scene.effects.find<LinearContactOptions>()));
          },
      .device = contact_on_device};
  return kind;
}

}  // namespace lichtenberg::effects
