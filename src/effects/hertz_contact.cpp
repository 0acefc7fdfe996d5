#include "src/effects/hertz_contact.hpp"

#include <fmt/format.h>

#include "solvers/error.hpp"
#include "src/effects/elastic_constants.hpp"
#include "src/model/neighbours.hpp"
#include "src/model/pair_loop.hpp"

namespace lichtenberg::effects {
namespace {

[[noreturn]] void refuse(const Bodies& bodies, Pair pair) {
  const double depth = visit_spheres(bodies, [&](const auto& s) {
    return s.radius[pair.i] + s.radius[pair.j] - norm(s.box.difference(s.place(pair.i), s.place(pair.j)));
  });
  throw Failure(
      fmt::format("conductors {} and {} overlap by {:.3g} m, more than a radius: their Young's modulus "
                  "(effects.hertz_contact.young, or their own) is too soft for the speed at which they met, or "
                  "mechanics.euler_step too long for how hard it is",
                  pair.i, pair.j, depth));
}

void complete(const Draft& draft, Scene& scene) {
  auto& options = *scene.effects.find<HertzContactOptions>();
  options.bodies = materials_of_bodies(draft, {options.young, options.poisson});
}

}  // namespace

const EffectKind& HertzContactOptions::kind() {
  static const EffectKind kind = {.name = "hertz_contact",
                                  .description = "elastic contact between spheres",
                                  .help =
                                      "Elastic spheres push each other apart, F = 4/3 E* sqrt(R_eff) overlap^(3/2) (D "
                                      "5.9). Their Young's modulus and "
                                      "Poisson's ratio also hold in contacts with walls (wall_contact); conductors and "
                                      "populations may have their own (conductor.young, population.young), "
                                      "1/E* = (1 - nu_i^2) / E_i + (1 - nu_j^2) / E_j.",
                                  .options = HertzContactOptions{},
                                  .keys = elastic_constants<HertzContactOptions>(),
                                  .dimensions = {2, 3},
                                  .periodic = true,
                                  .complete = complete,
                                  .make = [](const Scene& scene) {
                                    return std::make_unique<HertzContact>(*scene.effects.find<HertzContactOptions>());
                                  }};
  return kind;
}

HertzContact::HertzContact(const HertzContactOptions& options)
    : modulus_(contact_modulus({options.young, options.poisson}, {options.young, options.poisson})),
      bodies_(options.bodies) {}

void HertzContact::add_forces(const State& state, std::span<double> force) const {
  if (!bodies_.empty()) {
    if (const auto refused = add_forces_of_unlike(state, force)) refuse(state.bodies, *refused);
    return;
  }
  const PairSum sum = visit_spheres(state.bodies, [&](const auto& spheres) {
    return add_pair_forces(HertzLaw{modulus_}, spheres, state.neighbours, force, state.team);
  });
  if (sum.refused) refuse(state.bodies, *sum.refused);
}

/// Adds the forces of each pair with its own modulus. Returns the first pair that the law refuses.
std::optional<Pair> HertzContact::add_forces_of_unlike(const State& state, std::span<double> force) const {
  std::optional<Pair> refused;
  const int d = state.bodies.dimension;
  visit_spheres(state.bodies, [&](const auto& spheres) {
    const HertzLaw common{modulus_};
    const bool apart = for_each_in_reach(common, spheres, state.neighbours, [&](const auto& found) {
      const auto [i, j] = found.pair;
      const HertzLaw one = law(found.pair);
      if (one.refuses(found.seen) && !refused) refused = found.pair;
      const double over_distance = one(found.seen).force / found.seen.distance;
      for (int k = 0; k < d; ++k) {
        force[i * d + k] += over_distance * found.apart[k];
        force[j * d + k] -= over_distance * found.apart[k];
      }
    });
    // The loop ends where two centres coincide, which the law refuses whatever the material.
    if (!apart) refused = add_pair_forces(common, spheres, state.neighbours, force, state.team).refused;
  });
  return refused;
}

double HertzContact::stored_energy(const State& state) const {
  double energy = 0;
  visit_spheres(state.bodies, [&](const auto& spheres) {
    for_each_in_reach(HertzLaw{modulus_}, spheres, state.neighbours,
                      [&](const auto& found) { energy += law(found.pair)(found.seen).energy; });
  });
  return energy;
}

void HertzContact::add_jacobian(const State& state, ForceJacobian& jacobian) const {
  visit_spheres(state.bodies, [&](const auto& spheres) {
    for_each_in_reach(HertzLaw{modulus_}, spheres, state.neighbours,
                      [&](const auto& found) { add_pair_derivatives(law(found.pair), found, jacobian); });
  });
}

void HertzContact::mark_pushed(const Bodies& bodies, std::span<const double> travel, std::vector<bool>& pushed) const {
  for (const Pair pair : pairs_within_reach(near_, bodies, 0, travel)) pushed[pair.i] = pushed[pair.j] = true;
}

}  // namespace lichtenberg::effects
