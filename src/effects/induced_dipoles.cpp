#include "src/effects/induced_dipoles.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "solvers/laplace/accuracy/cost_model.hpp"
#include "src/effects/device_forces.hpp"
#include "src/model/effect.hpp"
#include "src/scene/si.hpp"

namespace lichtenberg::effects {
namespace {

/// Effect without functions for the table [effects.induced_dipoles], whose options the effect `coulomb` reads.
class InducedDipoles : public Effect {
 public:
  const EffectKind& kind() const override { return InducedDipolesOptions::kind(); }
};

/// Throws InputError for a polarizability that no grain has, and in SI for a missing one.
void check_permittivities(const Draft& draft) {
  const auto has_own = [](const auto& of) { return of.permittivity > 0; };
  const bool all = std::ranges::all_of(draft.populations, has_own) &&
                   std::ranges::all_of(draft.conductors, [&](const auto& given) { return has_own(given.conductor); });
  if (!all || (draft.conductors.empty() && draft.populations.empty()))
    return require_in_si(draft, "effects.induced_dipoles.polarizability");
  refuse_if_given(draft, "effects.induced_dipoles.polarizability",
                  "has no effect, because all grains have a relative_permittivity: leave it out");
}

void check_induced_dipoles(const Draft& draft) {
  // The mutual polarization of two touching grains diverges at r^3 = 2 A.
  const auto& options = *draft.scene.effects.find<InducedDipolesOptions>();
  check_permittivities(draft);
  constexpr double most = 0.5;
  if (options.polarizability >= most)
    refuse(draft.scene.path, draft.line("effects.induced_dipoles.polarizability"),
           fmt::format("effects.induced_dipoles.polarizability = {:g} is not allowed: two grains in contact would have "
                       "a diverging mutual polarization; less than {:g} is allowed, and 0.125 is a conductor's",
                       options.polarizability, most));
  const Domain& domain = draft.scene.domain;
  const bool has_images = std::ranges::all_of(domain.sides, &DomainSide::periodic);
  if (options.degree == 1 && !has_images && options.sum != periodic::DipoleSum::ewald)
    refuse(draft.scene.path, draft.line("effects.induced_dipoles.sum"),
           fmt::format("effects.induced_dipoles.sum = \"{}\" is not allowed in a domain that is not periodic along all "
                       "axes: \"ewald\" is",
                       name_of(options.sum)));
  if (options.degree == 1) return;
  for (int s = 0; s < 6 && !domain.open; ++s)
    if (!domain.sides[s].periodic && !domain.sides[s].electrode)
      refuse(
          draft.scene.path, draft.line("effects.induced_dipoles.degree"),
          fmt::format("effects.induced_dipoles.degree above 1 is not allowed with domain.{} = \"insulating\", beyond "
                      "which the charges of grains have empty space: \"periodic\", {{ potential = 0 }} or "
                      "domain.unbounded is",
                      side_names[s]));
  const int line = draft.line("effects.induced_dipoles.degree");
  if (draft.line("effects.induced_dipoles.sum") > 0)
    refuse(draft.scene.path, line,
           "effects.induced_dipoles.degree above 1 is not allowed with effects.induced_dipoles.sum, which is for "
           "dipoles: leave one of the two out");
  // Limits of laplace::SphereSolver.
  if (!(options.tolerance >= 1e-12 && options.tolerance <= 0.1))
    refuse(draft.scene.path, draft.line("effects.induced_dipoles.tolerance"),
           fmt::format("effects.induced_dipoles.tolerance = {:g} is not allowed with a degree above 1: it must be at "
                       "least 1e-12 and at most 0.1",
                       options.tolerance));
}

/// Computes the polarizability (eps_r - 1) / (eps_r + 2) R^3 of grains with their own permittivity.
void set_polarizabilities(InducedDipolesOptions& options, const std::vector<Conductor>& grains) {
  if (std::ranges::none_of(grains, [](const Conductor& grain) { return grain.permittivity > 0; })) return;
  options.each.assign(grains.size(), options.polarizability);
  for (std::size_t i = 0; i < grains.size(); ++i)
    if (const double eps = grains[i].permittivity; eps > 0)
      options.each[i] = (eps - 1) / (eps + 2) * std::pow(grains[i].radius, 3);
  options.polarizability = std::ranges::max(options.each);
}

void complete_induced_dipoles(const Draft& draft, Scene& scene) {
  auto& options = *scene.effects.find<InducedDipolesOptions>();
  const double shared = options.polarizability;
  set_polarizabilities(options, scene.conductors);
  if (options.degree == 1) return;
  double least = INFINITY;
  for (const Conductor& grain : scene.conductors)
    if (grain.permittivity == 0) least = std::min(least, grain.radius);
  const double most = std::pow(least, 3);
  if (shared >= most)
    refuse(draft.scene.path, draft.line("effects.induced_dipoles.degree"),
           fmt::format(
               "effects.induced_dipoles.degree above 1 is for dielectric spheres: a polarizability less than {:g}, "
               "a conductor's of the smallest grain, is allowed",
               most));
}

void induced_dipoles_on_device(const Scene& scene, DeviceForces& forces) {
  const auto& options = *scene.effects.find<InducedDipolesOptions>();
  if (options.sum != periodic::DipoleSum::ewald)
    refuse_on_device(scene, fmt::format("effects.induced_dipoles.sum = \"{}\"", name_of(options.sum)));
  if (options.degree > 1) refuse_on_device(scene, "effects.induced_dipoles.degree above 1");
  if (!options.each.empty()) refuse_on_device(scene, "relative_permittivity of grains");
  forces.polarizability = options.polarizability, forces.dipole_tolerance = options.tolerance;
  constexpr double a_dipole = 450;  // bytes of a dipole, including its history and the arrays of its solver
  forces.bytes += a_dipole * static_cast<double>(scene.conductors.size());
}

/// Returns the estimated wall time (s) of the induced dipoles for one grain in one step. Above degree 1 a field of
/// dielectric spheres is solved in each step.
double seconds_a_grain(const Scene& scene) {
  const auto& options = *scene.effects.find<InducedDipolesOptions>();
  if (options.degree == 1) return 2.1e-6;
  const double grains = static_cast<double>(scene.conductors.size());
  const double unknowns = grains * (options.degree + 1) * (options.degree + 1);
  return laplace::spheres_cost.seconds(unknowns, options.tolerance) / grains;
}

}  // namespace

double InducedDipolesOptions::relative_permittivity(std::size_t grain, double radius) const {
  const double conductor = radius * radius * radius, a = of(grain);
  return (conductor + 2 * a) / (conductor - a);
}

const EffectKind& InducedDipolesOptions::kind() {
  static const EffectKind kind = {
      .name = "induced_dipoles",
      .description = "charges polarize grains, whose dipoles act on all",
      .help =
          "Each grain is a point dipole (degree 1): its moment is A times the field of the charges and of the other "
          "dipoles at its centre (Singh 2019, equations 3.22 to 3.34, with corrected signs unless sum = \"source\"). "
          "Above degree 1 grains are dielectric spheres with multipoles.",
      .options = InducedDipolesOptions{},
      .keys =
          {{.name = "polarizability",
            .target = target<&InducedDipolesOptions::polarizability>,
            .unit = "d0^3",
            .range = ranges::positive,
            .help =
                "polarizability A of a grain, in reduced units (d0^3): (eps_r - 1) / (eps_r + 2) / 8 of a "
                "dielectric sphere of diameter d0 and relative permittivity eps_r, 1/8 of a conductor of this size"},
           {.name = "sum",
            .target = target<&InducedDipolesOptions::sum>,
            .help =
                "periodic images in the interactions of charges and dipoles. ewald: all images, by Ewald sums; "
                "mixed-consistent: between dipoles near images only; minimum-image: near images only, except between "
                "charges; source: as printed in Singh 2019, with forces that derive from no energy. Near images are "
                "nearest images closer than half of the shortest edge of the domain"},
           {.name = "tolerance",
            .target = target<&InducedDipolesOptions::tolerance>,
            .range = ranges::accuracy,
            .help = "tolerance of the iteration for the dipoles: residual of the polarizing field, relative to the "
                    "field of the charges. Above degree 1: accuracy of the solution with multipoles"},
           {.name = "degree",
            .target = target<&InducedDipolesOptions::degree>,
            .range = {.low = 1, .high = InducedDipolesOptions::most},
            .help =
                "largest degree of the multipoles of a grain, 1 for dipoles. Above 1 grains are uniformly charged "
                "dielectric spheres, and the forces are valid up to contact. Then sum is not allowed, and coulomb.sum "
                "has no effect. The command explain prints the truncation error"}},
      .needs = {{"coulomb", "whose field polarizes"}},
      .dimensions = {3},
      .periodic = true,
      .grains = true,
      .check = check_induced_dipoles,
      .complete = complete_induced_dipoles,
      .make = [](const Scene&) { return std::make_unique<InducedDipoles>(); },
      // Two dipoles A e along the line between them satisfy e = 2 A e / r^3 at the divergence.
      .closest_approach =
          [](const Scene& scene) {
            const auto& options = *scene.effects.find<InducedDipolesOptions>();
            return options.degree == 1 ? std::cbrt(2 * options.polarizability) : 0.0;
          },
      .cost = {.seconds = seconds_a_grain},
      .device = induced_dipoles_on_device};
  return kind;
}

}  // namespace lichtenberg::effects
