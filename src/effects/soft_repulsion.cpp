#include "src/effects/soft_repulsion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "solvers/error.hpp"
#include "src/effects/gravity.hpp"
#include "src/model/neighbours.hpp"

namespace lichtenberg::effects {
namespace {

/// Calls visit(overlap) for every overlapping pair of particles among `pairs`. Stops and returns false if two centres
/// coincide, where the energy is infinite.
template <class Visit>
bool visit_pairs(const State& state, std::span<const Pair> pairs, Visit visit) {
  return visit_spheres(state.bodies, [&]<int d>(const Spheres<d>& spheres) {
    return for_each_in_reach(ContactPotentialLaw{}, spheres, pairs, [&](const PairInReach<d>& found) {
      Overlap o{.particle = found.pair.i, .partner = found.pair.j, .distance = found.geometry.distance};
      o.reach = found.geometry.reach;
      o.q = o.distance / o.reach;
      for (int k = 0; k < d; ++k) o.normal[k] = found.separation[k] / o.distance;
      if (o.q < 1) visit(o);
    });
  });
}

template <int dimension>
double distance_from(const Wall& wall, const double* position) {
  double distance = 0;
  for (int k = 0; k < dimension; ++k) distance += (position[k] - wall.point[k]) * wall.normal[k];
  return distance;
}

/// Returns true if a particle i, first <= i < end, overlaps the wall. Few particles do, and the loop is vectorized.
template <int dimension>
bool any_touches(const Bodies& bodies, const Wall& wall, int first, int end) {
  int any = 0;
  for (int i = first; i < end; ++i)
    any |= distance_from<dimension>(wall, &bodies.position[i * dimension]) < bodies.radius[i];
  return any;
}

/// Calls visit(overlap) for each overlap of a particle i, first <= i < end, with a wall, in the order of the walls.
/// Stops and returns false if a particle's centre is on or beyond a wall.
template <int dimension, class Visit>
bool visit_walls(const State& state, const std::vector<Wall>& walls, int first, int end, Visit visit) {
  Overlap o;
  for (std::size_t w = 0; w < walls.size(); ++w) {
    if (!any_touches<dimension>(state.bodies, walls[w], first, end)) continue;
    for (int i = first; i < end; ++i) {
      o.distance = distance_from<dimension>(walls[w], &state.bodies.position[i * dimension]);
      o.reach = state.bodies.radius[i];
      if (!(o.distance < o.reach)) continue;
      if (o.distance <= 0) return false;
      o.particle = i, o.partner = state.bodies.size() + static_cast<int>(w);
      o.q = o.distance / o.reach;
      for (int k = 0; k < dimension; ++k) o.normal[k] = walls[w].normal[k];
      if (o.q < 1) visit(o);
    }
  }
  return true;
}

template <class Visit>
bool visit_walls(const State& state, const std::vector<Wall>& walls, int first, int end, Visit visit) {
  return state.bodies.dimension == 3 ? visit_walls<3>(state, walls, first, end, visit)
                                     : visit_walls<2>(state, walls, first, end, visit);
}
template <class Visit>
bool visit_overlaps(const State& state, const std::vector<Wall>& walls, Visit visit) {
  return visit_pairs(state, state.neighbours, visit) && visit_walls(state, walls, 0, state.bodies.size(), visit);
}

/// Throws InputError for weight along a periodic axis, which has no wall to balance it.
void check_weight(const Draft& draft) {
  const auto* gravity = draft.scene.effects.find<GravityOptions>();
  if (!gravity) return;
  const Vec3 direction = down(*gravity, draft.scene.domain);
  for (int k = 0; k < draft.scene.dimension(); ++k)
    if (direction[k] != 0 && draft.scene.domain.box().periodic(k))
      refuse(draft.scene.path, draft.line("effects.gravity"),
             fmt::format("effects.gravity is not allowed along {}, where the domain is periodic: no wall balances "
                         "the weight of a packing there; choose effects.gravity.direction across the periodic sides",
                         "xyz"[k]));
}

/// Throws InputError for pressures of loads that net forces hide.
void check_pressures(const Draft& draft, Scene& scene) {
  const double least = lowest_pressure(scene);
  for (const double pressure : scene.compression.pressure)
    if (pressure < least)
      refuse(scene.path, draft.line("compression.pressure"),
             fmt::format("compression.pressure = {:g} is not allowed: it must be at least {:.3g}, which is 100 "
                         "minimize.force_tolerance in units of stiffness / diameter^{}, because net forces hide lower "
                         "pressures",
                         pressure, least, scene.dimension()));
}

}  // namespace

const EffectKind& SoftRepulsionOptions::kind() {
  static const EffectKind kind = {
      .name = "soft_repulsion",
      .description = "particles that overlap each other or walls repel until all forces balance",
      .help =
          "Particles move to a minimum of the energy stiffness * sum of w(q) over all overlapping pairs and walls. "
          "Here "
          "q is the distance of the centres over the sum of the radii, or of a centre from a wall over its radius. A "
          "run finds this minimum and computes no motion in time, so no other effect than gravity is allowed.",
      .options = SoftRepulsionOptions{},
      .keys = {{.name = "stiffness",
                .target = target<&SoftRepulsionOptions::stiffness>,
                .unit = "J",
                .range = ranges::positive,
                .help = "stiffness of the contact energy, in J: it scales energies and forces and has no effect on the "
                        "final positions"},
               {.name = "form",
                .target = target<&SoftRepulsionOptions::form>,
                .help =
                    "form w(q) of the contact energy. logarithmic: (q - 1) ln q; harmonic: (1 - q)^2 / 2; hertzian: "
                    "(1 - q)^(5/2) / (5/2)"},
               {.name = "box",
                .target = [](Draft& draft) { return &draft.scene.domain.walled; },
                .help =
                    "true: the sides of the domain are walls, except periodic ones; false: only the tables [[wall]] "
                    "define walls"}},
      .alone = "which permits no other effect than gravity",
      .beside = "gravity",
      .dimensions = {2, 3},
      .periodic = true,
      .packing = true,
      .check = check_weight,
      .complete = check_pressures,
      .make = [](const Scene& scene) { return std::make_unique<SoftRepulsion>(scene); }};
  return kind;
}

double pressure_unit(const Scene& scene) {
  double diameter = 0;
  for (const Conductor& c : scene.conductors) diameter += 2 * c.radius;
  diameter /= static_cast<double>(scene.conductors.size());
  return scene.effects.find<SoftRepulsionOptions>()->stiffness / std::pow(diameter, scene.dimension());
}

double lowest_pressure(const Scene& scene) { return 100 * scene.minimize.force_tolerance * pressure_unit(scene); }

double SoftRepulsion::energy(const State& state) const {
  double sum = 0;
  const bool finite = visit_overlaps(state, walls_, [&](const Overlap& o) { sum += contact(o.q).energy; });
  return finite ? stiffness() * sum : INFINITY;
}

double SoftRepulsion::energy_and_forces(const State& state, std::span<double> force) const {
  std::vector<ParticleForce> none;
  return energy_and_forces(state, 0, state.bodies.size(), force, none);
}

double SoftRepulsion::energy_and_forces(const State& state, int first, int end, std::span<double> force,
                                        std::vector<ParticleForce>& outside_forces) const {
  return state.bodies.dimension == 3 ? range_energy_and_forces<3>(state, first, end, force, outside_forces)
                                     : range_energy_and_forces<2>(state, first, end, force, outside_forces);
}

template <int dimension>
double SoftRepulsion::range_energy_and_forces(const State& state, int first, int end, std::span<double> force,
                                              std::vector<ParticleForce>& outside_forces) const {
  PairSum sum;
  if (!add_walls<dimension>(state, first, end, force, sum.energy)) return INFINITY;
  add_pair_forces(law(), spheres<dimension>(state.bodies), state.neighbours, ParticleRange{first, end},
                  PairOutput{force, outside_forces, sum});
  return stiffness() * sum.energy;
}

template <int dimension>
bool SoftRepulsion::add_walls(const State& state, int first, int end, std::span<double> force, double& sum) const {
  return visit_walls<dimension>(state, walls_, first, end, [&](const Overlap& o) {
    const ContactLaw w = contact(o.q);
    sum += w.energy;
    for (int k = 0; k < dimension; ++k)
      force[o.particle * dimension + k] -= stiffness() * w.slope / o.reach * o.normal[k];
  });
}

void SoftRepulsion::add_forces(const State& state, std::span<double> force) const {
  if (std::isinf(energy_and_forces(state, force)))
    throw Failure(
        "a particle's centre lies on another, or on or beyond a wall: there the energy of effects.soft_repulsion is "
        "infinite");
}

void SoftRepulsion::add_jacobian(const State& state, ForceJacobian& jacobian) const {
  visit_spheres(state.bodies, [&](const auto& spheres) {
    for_each_in_reach(law(), spheres, state.neighbours,
                      [&](const auto& found) { add_pair_derivatives(law(), found, jacobian); });
  });
  visit_walls(state, walls_, 0, state.bodies.size(), [&](const Overlap& o) {
    const double along = -stiffness() * contact(o.q).curvature / (o.reach * o.reach);
    jacobian.add_central(o.particle, o.particle, o.normal, along, 0);  // a wall's normal is constant
  });
}

std::vector<Overlap> SoftRepulsion::overlaps(const State& state) const {
  return overlaps(state, 0, state.bodies.size());
}

std::vector<Overlap> SoftRepulsion::overlaps(const State& state, int first, int end) const {
  std::vector<Overlap> all;
  const auto take = [&](const Overlap& o) { all.push_back(o); };
  if (!visit_pairs(state, pairs_of(state.neighbours, {first, end}), take) ||
      !visit_walls(state, walls_, first, end, take))
    all.clear();
  return all;
}

}  // namespace lichtenberg::effects
