#include "src/effects/adhesion.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "src/effects/linear_contact.hpp"
#include "src/effects/surface_effect.hpp"
#include "src/effects/viscoelastic_contact.hpp"
#include "src/model/rough_contact.hpp"

namespace lichtenberg::effects {
namespace {

/// Returns the work of adhesion, twice the surface energy, in reduced units m0 v0^2 / d0^2.
double work_of_adhesion(const Scene& scene) {
  const auto [d0, m0, v0, q0] = *scene.reference;
  return 2 * scene.effects.find<AdhesionOptions>()->surface_energy * d0 * d0 / (m0 * v0 * v0);
}

void check_adhesion(const Draft& draft) {
  if (draft.scene.effects.find<AdhesionOptions>()->model == AdhesionModel::jkr &&
      draft.scene.effects.has<LinearContactOptions>())
    refuse(draft.scene.path, draft.line("effects.adhesion"),
           "effects.adhesion.model = \"jkr\" is not allowed with effects.linear_contact, which has no elastic modulus: "
           "\"dmt\" is, or use effects.viscoelastic_contact");
}

/// Returns the overlap at which two grains of diameter d0 are at rest, with a work of adhesion w.
double overlap_at_rest(const Scene& scene, double work) {
  const AdhesionModel model = scene.effects.find<AdhesionOptions>()->model;
  const double radius = 0.25, attraction = 2 * std::numbers::pi * work * radius;
  if (const auto* linear = scene.effects.find<LinearContactOptions>()) return attraction / linear->stiffness;
  const double elastic = scene.effects.find<ViscoelasticContactOptions>()->elastic;
  if (model == AdhesionModel::dmt) return std::pow(attraction / elastic, 2.0 / 3);
  const JkrContact jkr(work, radius, 0.75 * elastic / std::sqrt(radius));
  return jkr.length * std::cbrt(1.5) * 0.5;  // s^3 = 3/2: s^4 - s = s/2
}

/// Throws InputError for adhesion that compresses contacts beyond the range of contact laws.
void check_overlap(const Draft& draft, Scene& scene) {
  constexpr double most = 0.1;
  if (!scene.effects.has<LinearContactOptions>() && !scene.effects.has<ViscoelasticContactOptions>()) return;
  const double overlap = overlap_at_rest(scene, work_of_adhesion(scene));
  if (overlap <= most) return;
  const double given = scene.effects.find<AdhesionOptions>()->surface_energy;
  const double power = scene.effects.has<LinearContactOptions>() ? 1 : 1.5;
  refuse(scene.path, draft.line("effects.adhesion"),
         fmt::format("effects.adhesion.surface_energy = {:g} J/m^2 is too large for the stiffness of the contact: two "
                     "grains at rest would overlap by {:.2g} d0, and {:g} d0 is allowed; at most {:.2g} J/m^2, or a "
                     "larger stiffness, is needed",
                     given, overlap, most, 0.99 * given * std::pow(most / overlap, power)));
}

std::vector<ExplanationLine> explain_adhesion(const Scene& scene) {
  const auto& options = *scene.effects.find<AdhesionOptions>();
  const double w = work_of_adhesion(scene), radius = 0.25, effective_mass = 0.5;
  const bool is_jkr = options.model == AdhesionModel::jkr;
  std::string text = fmt::format("pull-off force {:.4g} m0 v0^2/d0 of two grains of diameter d0",
                                 (is_jkr ? 1.5 : 2) * std::numbers::pi * w * radius);
  if (is_jkr) {
    const double elastic = scene.effects.find<ViscoelasticContactOptions>()->elastic;
    const JkrContact jkr(w, radius, 0.75 * elastic / std::sqrt(radius));
    text += fmt::format("; without damping they stick up to an impact speed of {:.4g} v0",
                        std::sqrt(2 * jkr.energy(JkrContact::last) / effective_mass));
  }
  return {{"adhesion", text}};
}

}  // namespace

const EffectKind& AdhesionOptions::kind() {
  static const EffectKind kind = {
      .name = "adhesion",
      .description = "adhesion of grains",
      .help =
          "Grains in contact attract each other. dmt adds the constant force 2 pi w R_eff while they overlap "
          "(Derjaguin, "
          "Muller and Toporov 1975), for small, stiff grains. jkr is the contact of Johnson, Kendall and Roberts "
          "(1971), "
          "for large, soft grains: it begins at the overlap 0, and ends at a separating force of 3/2 pi w "
          "R_eff. The work of adhesion w is twice the surface energy. Walls attract like grains.",
      .options = AdhesionOptions{},
      .keys = {{.name = "model", .target = target<&AdhesionOptions::model>, .help = "model of adhesion"},
               {.name = "surface_energy",
                .target = target<&AdhesionOptions::surface_energy>,
                .unit = "J/m^2",
                .range = {.low = 0, .high = 1e100, .low_itself = false},
                .required = true,
                .help = "surface energy of the grains' material in SI, in J/m^2",
                .scale = Key::Scale::si}},
      .dimensions = {2, 3},
      .periodic = true,
      .grains = true,
      .check = check_adhesion,
      .complete = check_overlap,
      .make =
          [](const Scene& scene) {
            const AdhesionLaw law{scene.effects.find<AdhesionOptions>()->model, work_of_adhesion(scene)};
            return std::make_unique<SurfaceEffect>(AdhesionOptions::kind(),
                                                   [law](SurfaceLaw& surface) { surface.adhesion = law; });
          },
      .explain = explain_adhesion,
      .device = [](const Scene&, DeviceForces&) {}};
  return kind;
}

}  // namespace lichtenberg::effects
