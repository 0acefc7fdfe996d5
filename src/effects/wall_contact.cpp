#include "src/effects/wall_contact.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "solvers/error.hpp"
#include "src/effects/elastic_constants.hpp"
#include "src/effects/hertz_contact.hpp"

namespace lichtenberg::effects {
namespace {

/// Returns the elastic constants of conductors without keys of their own: those of effects.hertz_contact, otherwise
/// those of the walls.
Elasticity common_material(const Scene& scene) {
  if (const auto* spheres = scene.effects.find<HertzContactOptions>()) return {spheres->young, spheres->poisson};
  const auto& walls = *scene.effects.find<WallContactOptions>();
  return {walls.young, walls.poisson};
}

void complete_wall_contact(const Draft& draft, Scene& scene) {
  scene.effects.find<WallContactOptions>()->bodies = materials_of_bodies(draft, common_material(scene));
}

/// Returns true if body i cannot touch a wall while it moves by at most `travel` (m). `gap`: gap (m) to the nearest
/// wall at its position in `cached_position` (m, [N * dimension]).
bool is_away(const Bodies& bodies, int i, std::span<const double> cached_position, double gap, double travel) {
  double moved2 = 0;
  for (int k = i * bodies.dimension; k < (i + 1) * bodies.dimension; ++k)
    moved2 += (bodies.position[k] - cached_position[k]) * (bodies.position[k] - cached_position[k]);
  const double clearance = gap - travel;
  return clearance > 0 && moved2 < clearance * clearance;
}

}  // namespace

const EffectKind& WallContactOptions::kind() {
  static const EffectKind kind = {
      .name = "wall_contact",
      .description = "elastic contact of spheres with the sides of the domain and the electrodes",
      .help =
          "Elastic contact of spheres with the sides of the domain and the electrodes, by the force of Hertz as in "
          "hertz_contact. The sides and electrodes have the Young's modulus and Poisson's ratio of this table. The "
          "spheres have those of hertz_contact, or without it those of the walls, unless their [[conductor]] or "
          "[[population]] gives its own. With s for the sphere and w for the wall, 1/E* = (1 - nu_s^2) / E_s + (1 - "
          "nu_w^2) / E_w.",
      .options = WallContactOptions{},
      .keys = joined({elastic_constants<WallContactOptions>(), contact_loss_keys<WallContactOptions>()}),
      .dimensions = {2, 3},
      .periodic = true,
      .check = check_contact_losses<WallContactOptions>,
      .complete = complete_wall_contact,
      .make = [](const Scene& scene) { return std::make_unique<WallContact>(scene); }};
  return kind;
}

WallContact::WallContact(const Scene& scene) : loss_(scene.effects.find<WallContactOptions>()->losses) {
  const auto& options = *scene.effects.find<WallContactOptions>();
  const Elasticity wall{options.young, options.poisson};
  for (const Elasticity& body : options.bodies) modulus_.push_back(contact_modulus(body, wall));
  if (modulus_.empty()) modulus_ = {contact_modulus(common_material(scene), wall)};
  const std::vector<Surface> sides = sides_of(scene.domain);
  for (std::size_t s = 0; s < sides.size(); ++s)
    if (!scene.domain.open && !scene.domain.sides[s].periodic) walls_.push_back(sides[s]);
  for (const Electrode& electrode : scene.electrodes) walls_.push_back(surface_of(electrode, scene.domain));
}

template <class Visit>
void WallContact::for_each_contact(const State& state, Visit visit) const {
  const Bodies& bodies = state.bodies;
  for_each_requested(state, [&](int i) {
    if (!reaches(bodies, i, 0)) return;
    for (const Surface& wall : walls_) {
      const View seen = view(wall, position_in_space(bodies, i));
      const double overlap = bodies.radius[i] - seen.distance;
      if (overlap > 0) visit(i, seen, hertz(modulus(i), 1 / (1 / bodies.radius[i] + seen.curvature), overlap));
    }
  });
}

void WallContact::add_forces(const State& state, std::span<double> force) const {
  for_each_contact(state, [&](int i, const View& seen, const HertzForce& law) {
    if (seen.distance < 0)
      throw Failure(
          fmt::format("conductor {} is pressed into a side of the domain or an electrode by {:.3g} m, more than its "
                      "radius: Young's modulus (effects.wall_contact.young, or its own) is too "
                      "soft for its speed, or the integrator's step too long "
                      "for how hard it is",
                      i, state.bodies.radius[i] - seen.distance));
    const int d = state.bodies.dimension;
    for (int k = 0; k < d; ++k) force[i * d + k] += law.force * seen.normal[k];
    if (!loss_.any()) return;
    const Vec3 lost = loss(state.bodies, i, seen, law).force;
    for (int k = 0; k < d; ++k) force[i * d + k] += lost[k];
  });
}

double WallContact::dissipated_power(const State& state) const {
  double power = 0;
  if (loss_.any())
    for_each_contact(state, [&](int i, const View& seen, const HertzForce& law) {
      power += loss(state.bodies, i, seen, law).power;
    });
  return power;
}

double WallContact::stored_energy(const State& state) const {
  double energy = 0;
  for_each_contact(state, [&](int, const View&, const HertzForce& law) { energy += law.energy; });
  return energy;
}

void WallContact::add_jacobian(const State& state, ForceJacobian& jacobian) const {
  for_each_contact(state, [&](int i, const View& seen, const HertzForce& law) {
    const std::array<double, 3> normal = {seen.normal.x, seen.normal.y, seen.normal.z};
    jacobian.add_central(i, i, normal, -law.stiffness, law.force * seen.turning);
    if (loss_.any()) add_loss(loss(state.bodies, i, seen, law), i, -1, state.bodies, jacobian);
  });
}

bool WallContact::reaches(const Bodies& bodies, int i, double travel) const {
  const int d = bodies.dimension;
  if (gap_.size() != bodies.radius.size()) {
    gap_.assign(bodies.radius.size(), -INFINITY);
    cached_position_ = bodies.position;
  }
  if (is_away(bodies, i, cached_position_, gap_[i], travel)) return false;
  gap_[i] = INFINITY;
  for (const Surface& wall : walls_)
    gap_[i] = std::min(gap_[i], view(wall, position_in_space(bodies, i)).distance - bodies.radius[i]);
  std::copy_n(&bodies.position[i * d], d, &cached_position_[i * d]);
  return gap_[i] <= travel;
}

void WallContact::mark_interacting(const Bodies& bodies, std::span<const double> travel,
                                   std::vector<bool>& interacting) const {
  const bool cached = gap_.size() == bodies.radius.size();
  for (int i = 0; i < bodies.size(); ++i)
    if (!(cached && is_away(bodies, i, cached_position_, gap_[i], travel[i])) && reaches(bodies, i, travel[i]))
      interacting[i] = true;
}

}  // namespace lichtenberg::effects
