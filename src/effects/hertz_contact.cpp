#include "src/effects/hertz_contact.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "solvers/error.hpp"
#include "src/effects/elastic_constants.hpp"
#include "src/effects/hertz.hpp"
#include "src/model/neighbours.hpp"

namespace lichtenberg::effects {
namespace {

/// Two overlapping spheres.
struct Overlap {
  std::array<double, 3> normal{};  ///< from j to i
  double distance = 0;             ///< m, of the centres
  double depth = 0;                ///< m; not positive: they do not touch
};

Overlap overlap(const Bodies& bodies, Pair pair) {
  Overlap result;
  double sum = 0;
  for (int k = 0; k < bodies.dimension; ++k) {
    result.normal[k] = bodies.position[pair.i * bodies.dimension + k] - bodies.position[pair.j * bodies.dimension + k];
    sum += result.normal[k] * result.normal[k];
  }
  result.distance = std::sqrt(sum);
  result.depth = bodies.radius[pair.i] + bodies.radius[pair.j] - result.distance;
  for (double& n : result.normal) n /= result.distance;
  return result;
}

/// Hertz's law is for overlaps much smaller than the spheres, and centres that pass each other are no contact at all.
void check_depth(const Bodies& bodies, Pair pair, double depth) {
  if (depth <= std::min(bodies.radius[pair.i], bodies.radius[pair.j])) return;
  throw Failure(fmt::format(
      "conductors {} and {} overlap by {:.3g} m, more than a radius: effects.hertz_contact.young is too soft "
      "for the speed at which they met, or mechanics.euler_step too long for how hard it is",
      pair.i, pair.j, depth));
}

double effective_radius(const Bodies& bodies, Pair pair) {
  return 1 / (1 / bodies.radius[pair.i] + 1 / bodies.radius[pair.j]);
}

}  // namespace

const EffectKind& HertzContactOptions::kind() {
  static const EffectKind kind = {
      .name = "hertz_contact",
      .description = "elastic contact between spheres",
      .help = "Elastic spheres push each other apart, F = 4/3 E* sqrt(R_eff) overlap^(3/2) (D 5.9).",
      .options = HertzContactOptions{},
      .keys = elastic_constants<HertzContactOptions>(),
      .dimensions = {2, 3},
      .make = [](const Scene& scene) -> std::unique_ptr<Effect> {
        return std::make_unique<HertzContact>(*scene.effects.find<HertzContactOptions>());
      }};
  return kind;
}

HertzContact::HertzContact(const HertzContactOptions& options)
    : modulus_(contact_modulus(options.young, options.poisson)) {}

void HertzContact::add_forces(const State& state, std::span<double> force) const {
  const int d = state.bodies.dimension;
  for (const Pair pair : state.neighbours) {
    const Overlap o = overlap(state.bodies, pair);
    if (!(o.depth > 0)) continue;
    check_depth(state.bodies, pair, o.depth);
    const double push = hertz(modulus_, effective_radius(state.bodies, pair), o.depth).force;
    for (int k = 0; k < d; ++k) {
      force[pair.i * d + k] += push * o.normal[k];
      force[pair.j * d + k] -= push * o.normal[k];
    }
  }
}

double HertzContact::stored_energy(const State& state) const {
  double energy = 0;
  for (const Pair pair : state.neighbours)
    if (const Overlap o = overlap(state.bodies, pair); o.depth > 0)
      energy += hertz(modulus_, effective_radius(state.bodies, pair), o.depth).energy;
  return energy;
}

void HertzContact::add_jacobian(const State& state, ForceJacobian& jacobian) const {
  for (const Pair pair : state.neighbours) {
    const Overlap o = overlap(state.bodies, pair);
    if (!(o.depth > 0)) continue;
    const HertzForce law = hertz(modulus_, effective_radius(state.bodies, pair), o.depth);
    // Moving i away from j takes overlap away; moving it sideways turns the force, which has an arm of one distance.
    const double along = -law.stiffness, across = law.force / o.distance;
    jacobian.add_central(pair.i, pair.i, o.normal, along, across);
    jacobian.add_central(pair.j, pair.j, o.normal, along, across);
    jacobian.add_central(pair.i, pair.j, o.normal, -along, -across);
    jacobian.add_central(pair.j, pair.i, o.normal, -along, -across);
  }
}

bool HertzContact::idle(const Bodies& bodies, std::span<const double> travel) const {
  return pairs_within_reach(bodies, 0, travel).empty();
}

}  // namespace lichtenberg::effects
