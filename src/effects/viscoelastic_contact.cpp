#include "src/effects/viscoelastic_contact.hpp"

#include "src/effects/grain_contact_effect.hpp"

namespace lichtenberg::effects {

const EffectKind& ViscoelasticContactOptions::kind() {
  static const EffectKind kind = {
      .name = "viscoelastic_contact",
      .description = "viscoelastic contact of grains",
      .help =
          "Grains in contact repel each other by F = max(E overlap^(3/2) + D sqrt(overlap) d overlap/dt, 0) (G 3.10 "
          "with the clamp of G 3.9), which loses more of fast impacts than of slow ones.",
      .options = ViscoelasticContactOptions{},
      .keys = {{.name = "elastic",
                .place = place<&ViscoelasticContactOptions::elastic>,
                .range = ranges::positive,
                .help = "E = alpha d0^(5/2) / (m0 v0^2), alpha = 2 Y sqrt(d0/4) / (3 (1 - nu^2)) (G 3.11, 3.36)"},
               {.name = "dissipative",
                .place = place<&ViscoelasticContactOptions::dissipative>,
                .range = ranges::not_negative,
                .help = "D = gamma alpha d0^(3/2) / (m0 v0) (G 3.12)"}},
      .dimensions = {2, 3},
      .periodic = true,
      .grains = true,
      .make = [](const Scene& scene) -> std::unique_ptr<Effect> {
        const auto& options = *scene.effects.find<ViscoelasticContactOptions>();
        return std::make_unique<GrainContactEffect>(ViscoelasticContactOptions::kind(),
                                                    ViscoelasticLaw{options.elastic, options.dissipative});
      }};
  return kind;
}

}  // namespace lichtenberg::effects
