#include "src/effects/viscoelastic_contact.hpp"

#include <fmt/format.h>

#include <cmath>

#include "src/effects/grain_contact_effect.hpp"

namespace lichtenberg::effects {
namespace {

/// Throws InputError unless either the reduced constants (stiffness, damping) or all of the SI parameters (young,
/// poisson, viscosity) are given, or none.
void check_viscoelastic_contact(const Draft& draft) {
  const auto& options = *draft.scene.effects.find<ViscoelasticContactOptions>();
  const auto path = [](const std::string& key) { return "effects.viscoelastic_contact." + key; };
  const bool some = options.young || options.poisson || options.viscosity || draft.scene.in_si;
  for (const char* pure : {"stiffness", "damping"})
    if (some)
      refuse_if_given(draft, path(pure),
                      "is given, and so are young, poisson or viscosity in SI, from which it follows: leave one of the "
                      "two out");
  for (const auto& [key, value] :
       {std::pair{"young", options.young}, {"poisson", options.poisson}, {"viscosity", options.viscosity}})
    if (some && !value)
      refuse(draft.scene.path, draft.line("effects.viscoelastic_contact"),
             fmt::format("{} is missing: young, poisson and viscosity are given together, or none of them", path(key)));
}

/// Computes the reduced constants E and D from the SI parameters and the scene's units (Singh 2019, eq. 3.11, 3.12,
/// 3.36). Has no effect if no SI parameters are given.
void set_reduced_constants(const Draft& draft, Scene& scene) {
  auto& options = *scene.effects.find<ViscoelasticContactOptions>();
  if (!options.young || !draft.scene.reference) return;
  const auto [d0, m0, v0, q0] = *draft.scene.reference;
  const double nu = *options.poisson, alpha = 2 * *options.young * std::sqrt(d0 / 4) / (3 * (1 - nu * nu));
  options.elastic = alpha * std::pow(d0, 2.5) / (m0 * v0 * v0);
  constexpr double least = 1e-100, most = 1e100;  // as for the key stiffness
  if (!(options.elastic >= least && options.elastic <= most))
    refuse(
        draft.scene.path, draft.line("effects.viscoelastic_contact.young"),
        fmt::format("effects.viscoelastic_contact.young = {:g} gives a reduced stiffness of {:g} in the units of the "
                    "scene: at least {:g} and at most {:g} is allowed",
                    *options.young, options.elastic, least, most));
  options.dissipative = *options.viscosity * v0 / d0 * options.elastic;
}

}  // namespace

const EffectKind& ViscoelasticContactOptions::kind() {
  static const EffectKind kind = {
      .name = "viscoelastic_contact",
      .description = "viscoelastic contact of grains",
      .help =
          "Grains in contact repel each other by the force F = max(E overlap^(3/2) + D sqrt(overlap) d overlap/dt, 0) "
          "of viscoelastic spheres (Singh 2019, eq. 3.10 with the non-attractive cut-off of eq. 3.9). E and D are for "
          "two grains of diameter d0; other pairs have the factor sqrt(4 R_eff / d0), 1/R_eff = 1/R_i + 1/R_j. With "
          "damping, fast impacts lose a larger fraction of their energy than slow ones.",
      .options = ViscoelasticContactOptions{},
      .keys = {{.name = "stiffness",
                .target = target<&ViscoelasticContactOptions::elastic>,
                .range = {.low = 1e-100, .high = 1e100},  // squares must not overflow
                .help = "dimensionless stiffness E of the contact force, E = alpha d0^(5/2) / (m0 v0^2) with alpha = 2 "
                        "Y sqrt(d0/4) / (3 (1 - nu^2)), Young's modulus Y, Poisson's ratio nu and the scales of "
                        "[units] (Singh 2019, equations 3.11 and 3.36)",
                .old_name = "elastic",
                .scale = Key::Scale::reduced},
               {.name = "damping",
                .target = target<&ViscoelasticContactOptions::dissipative>,
                .range = ranges::not_negative,
                .help = "dimensionless damping D of the contact force, D = gamma v0 / d0 E with the material's viscous "
                        "time gamma in s and the stiffness E (Singh 2019, eq. 3.12)",
                .old_name = "dissipative",
                .scale = Key::Scale::reduced},
               {.name = "young",
                .target = target<&ViscoelasticContactOptions::young>,
                .unit = "Pa",
                .range = ranges::positive,
                .computed_default = "none",
                .help = "Young's modulus Y of the grains' material in SI, in Pa. Give it with poisson and viscosity "
                        "instead of stiffness and damping, which then follow by the scales of [units]",
                .scale = Key::Scale::si},
               {.name = "poisson",
                .target = target<&ViscoelasticContactOptions::poisson>,
                .range = {.low = -1, .high = 0.5, .low_itself = false},
                .computed_default = "none",
                .help = "Poisson's ratio nu of the grains' material; give it with young and viscosity"},
               {.name = "viscosity",
                .target = target<&ViscoelasticContactOptions::viscosity>,
                .unit = "s",
                .range = ranges::not_negative,
                .computed_default = "none",
                .help = "viscous time gamma of the grains' material in SI, in s, the ratio of damping to stiffness: "
                        "the damping is D = gamma v0 / d0 E",
                .scale = Key::Scale::si}},
      .dimensions = {2, 3},
      .periodic = true,
      .grains = true,
      .check = check_viscoelastic_contact,
      .complete = set_reduced_constants,
      .make =
          [](const Scene& scene) {
            const auto& options = *scene.effects.find<ViscoelasticContactOptions>();
            return std::make_unique<GrainContactEffect>(ViscoelasticContactOptions::kind(),
                                                        ViscoelasticLaw{options.elastic, options.dissipative});
          },
      .explain = [](const Scene& scene) -> std::vector<ExplanationLine> {
        const auto& options = *scene.effects.find<ViscoelasticContactOptions>();
        return {{"contact", fmt::format("E = {:.6g}, D = {:.6g}", options.elastic, options.dissipative)}};
      },
      .device = contact_on_device};
  return kind;
}

}  // namespace lichtenberg::effects
