#include "src/effects/hertz_contact.hpp"

#include <fmt/format.h>

#include "solvers/error.hpp"
#include "src/effects/elastic_constants.hpp"

namespace lichtenberg::effects {
namespace {

void complete_hertz_contact(const Draft& draft, Scene& scene) {
  auto& options = *scene.effects.find<HertzContactOptions>();
  options.bodies = materials_of_bodies(draft, {options.young, options.poisson});
}

}  // namespace

const EffectKind& HertzContactOptions::kind() {
  static const EffectKind kind = {
      .name = "hertz_contact",
      .description = "elastic contact between spheres",
      .help =
          "Elastic spheres repel each other in contact with the force F = 4/3 E* sqrt(R_eff) overlap^(3/2) of Hertz "
          "(Stephenson 2018, eq. 5.9). Here 1/R_eff = 1/R_i + 1/R_j and 1/E* = (1 - nu_i^2) / E_i + (1 - nu_j^2) / "
          "E_j, with Young's modulus E and Poisson's ratio nu of each sphere. Conductors and populations may have "
          "their own (conductor.young, population.young); those of this table are the default, also in contacts with "
          "walls (wall_contact). Contacts may dissipate energy by restitution and friction.",
      .options = HertzContactOptions{},
      .keys = joined({elastic_constants<HertzContactOptions>(), contact_loss_keys<HertzContactOptions>()}),
      .dimensions = {2, 3},
      .periodic = true,
      .check = check_contact_losses<HertzContactOptions>,
      .complete = complete_hertz_contact,
      .make = [](const Scene& scene) {
        return std::make_unique<HertzContact>(*scene.effects.find<HertzContactOptions>());
      }};
  return kind;
}

HertzContact::HertzContact(const HertzContactOptions& options)
    : PairEffect(HertzContactOptions::kind(),
                 HertzLaw{contact_modulus({options.young, options.poisson}, {options.young, options.poisson})},
                 std::span<const double>()),
      bodies_(options.bodies),
      loss_(options.losses) {}

void HertzContact::refuse(const Bodies& bodies, Pair pair) const {
  const double depth = visit_spheres(bodies, [&](const auto& s) {
    return s.radius[pair.i] + s.radius[pair.j] - norm(s.box.difference(s.centre(pair.i), s.centre(pair.j)));
  });
  throw Failure(
      fmt::format("conductors {} and {} overlap by {:.3g} m, more than a radius: their Young's modulus "
                  "(effects.hertz_contact.young, or their own) is too soft for the speed at which they met, or "
                  "the integrator's step too long for how hard it is",
                  pair.i, pair.j, depth));
}

void HertzContact::add_forces(const State& state, std::span<double> force) const {
  if (bodies_.empty())
    PairEffect::add_forces(state, force);
  else if (const auto refused = add_forces_of_unlike(state, force))
    refuse(state.bodies, *refused);
  const int d = state.bodies.dimension;
  for_each_loss(state, [&](Pair pair, const LossForce& loss) {
    for (int k = 0; k < d; ++k) {
      force[pair.i * d + k] += loss.force[k];
      force[pair.j * d + k] -= loss.force[k];
    }
  });
}

template <class Visit>
void HertzContact::for_each_loss(const State& state, const Visit& visit) const {
  if (!loss_.any()) return;
  const Bodies& bodies = state.bodies;
  visit_spheres(bodies, [&](const auto& spheres) {
    for_each_in_reach(law(), spheres, state.neighbours, [&](const auto& found) {
      const auto [i, j] = found.pair;
      const PairForce elastic = law_of(found.pair)(found.geometry);
      Vec3 normal;
      for (int k = 0; k < bodies.dimension; ++k) normal[k] = found.separation[k] / found.geometry.distance;
      const double mass = bodies.mass[i] / (1 + bodies.mass[i] / bodies.mass[j]);
      visit(found.pair, loss_({elastic.force, elastic.stiffness, elastic.energy}, mass, normal,
                              velocity_in_space(bodies, i) - velocity_in_space(bodies, j)));
    });
  });
}

void HertzContact::add_jacobian(const State& state, ForceJacobian& jacobian) const {
  PairEffect::add_jacobian(state, jacobian);
  for_each_loss(state,
                [&](Pair pair, const LossForce& loss) { add_loss(loss, pair.i, pair.j, state.bodies, jacobian); });
}

double HertzContact::dissipated_power(const State& state) const {
  double power = 0;
  for_each_loss(state, [&](Pair, const LossForce& loss) { power += loss.power; });
  return power;
}

std::optional<Pair> HertzContact::add_forces_of_unlike(const State& state, std::span<double> force) const {
  std::optional<Pair> refused;
  const int d = state.bodies.dimension;
  visit_spheres(state.bodies, [&](const auto& spheres) {
    const HertzLaw& common = law();
    const bool separate = for_each_in_reach(common, spheres, state.neighbours, [&](const auto& found) {
      const auto [i, j] = found.pair;
      const HertzLaw one = law_of(found.pair);
      if (one.refuses(found.geometry) && !refused) refused = found.pair;
      const double over_distance = one(found.geometry).force / found.geometry.distance;
      for (int k = 0; k < d; ++k) {
        force[i * d + k] += over_distance * found.separation[k];
        force[j * d + k] -= over_distance * found.separation[k];
      }
    });
    // The loop stops at coinciding centres, for which the law is not valid whatever the material.
    if (!separate) refused = add_pair_forces(common, spheres, state.neighbours, force, state.team).refused;
  });
  return refused;
}

}  // namespace lichtenberg::effects
