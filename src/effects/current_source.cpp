#include "src/effects/current_source.hpp"

namespace lichtenberg::effects {

const EffectKind& CurrentSourceOptions::kind() {
  static const EffectKind kind = {
      .name = "current_injection",
      .description = "a constant current into every conductor",
      .help = "The same current is injected into every conductor, dQ/dt = current (D 5.5). Needs floating_conductors.",
      .options = CurrentSourceOptions{},
      .keys = {{.name = "current",
                .target = target<&CurrentSourceOptions::current>,
                .unit = "A",
                .required = true,
                .help = "current into each conductor"}},
      .needs = {{"floating_conductors"}},
      .dimensions = {2, 3},
      .periodic = true,
      .make = [](const Scene& scene) {
        return std::make_unique<CurrentSource>(scene.effects.find<CurrentSourceOptions>()->current);
      }};
  return kind;
}

}  // namespace lichtenberg::effects
