#include "src/effects/current_injection.hpp"

namespace lichtenberg::effects {

const EffectKind& CurrentInjectionOptions::kind() {
  static const EffectKind kind = {
      .name = "current_injection",
      .description = "a constant current into every conductor",
      .help =
          "The same current is injected into every conductor, dQ/dt = current (Stephenson 2018, eq. 5.5). Needs "
          "floating_conductors.",
      .options = CurrentInjectionOptions{},
      .keys = {{.name = "current",
                .target = target<&CurrentInjectionOptions::current>,
                .unit = "A",
                .required = true,
                .help = "current into each conductor, in A; it changes the conductor's charge Q by dQ/dt = current"}},
      .needs = {{"floating_conductors"}},
      .dimensions = {2, 3},
      .periodic = true,
      .make = [](const Scene& scene) {
        return std::make_unique<CurrentInjection>(scene.effects.find<CurrentInjectionOptions>()->current);
      }};
  return kind;
}

}  // namespace lichtenberg::effects
