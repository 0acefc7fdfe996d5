#include "src/effects/leakage.hpp"

#include <fmt/format.h>

namespace lichtenberg::effects {
namespace {

Leakage leakage_of(const Scene& scene) {
  return Leakage(*scene.effects.find<LeakageOptions>(), scene.medium.permittivity);
}

}  // namespace

const EffectKind& LeakageOptions::kind() {
  static const EffectKind kind = {
      .name = "leakage",
      .description = "the fluid conducts: charge decays with its relaxation time",
      .help =
          "Ohmic conduction through the fluid: charge decays exponentially with the time constant permittivity / "
          "conductivity. Needs floating_conductors.",
      .options = LeakageOptions{},
      .keys = {{.name = "conductivity",
                .target = target<&LeakageOptions::conductivity>,
                .unit = "S/m",
                .range = ranges::positive,
                .required = true,
                .help = "electrical conductivity of the fluid, in S/m"}},
      .needs = {{"floating_conductors"}},
      .dimensions = {2, 3},
      .periodic = true,
      .make = [](const Scene& scene) { return std::make_unique<Leakage>(leakage_of(scene)); },
      .explain = [](const Scene& scene) -> std::vector<ExplanationLine> {
        return {
            {"leakage", fmt::format("every charge decays in {:.4g} s", leakage_of(scene).charge_relaxation_time())}};
      }};
  return kind;
}

}  // namespace lichtenberg::effects
