#include "src/analysis/packing.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "src/effects/contact_law.hpp"
#include "src/effects/contact_potential.hpp"

namespace lichtenberg::analysis {
namespace {

/// Takes out particles with too few contacts until none is left.
std::vector<bool> find_rattlers(const std::vector<PackingContact>& contacts, int particles, int needed) {
  std::vector<std::vector<int>> partners(particles);
  for (const PackingContact& c : contacts) {
    partners[c.particle].push_back(c.partner);
    if (c.partner < particles) partners[c.partner].push_back(c.particle);
  }
  std::vector<int> held(particles), loose;
  std::vector<bool> rattler(particles);
  for (int i = 0; i < particles; ++i) {
    held[i] = static_cast<int>(partners[i].size());
    if (held[i] < needed) rattler[i] = true, loose.push_back(i);
  }
  while (!loose.empty()) {
    const int i = loose.back();
    loose.pop_back();
    for (const int j : partners[i])
      if (j < particles && !rattler[j] && --held[j] < needed) rattler[j] = true, loose.push_back(j);
  }
  return rattler;
}

void count_contacts(Packing& packing, int particles) {
  std::int64_t ends = 0, backbone_ends = 0;
  for (const PackingContact& c : packing.contacts) {
    const bool pair = c.partner < particles;
    ends += pair ? 2 : 1;
    if (!packing.rattler[c.particle] && !(pair && packing.rattler[c.partner])) backbone_ends += pair ? 2 : 1;
  }
  packing.rattlers = static_cast<int>(std::ranges::count(packing.rattler, true));
  const int backbone = particles - packing.rattlers;
  packing.coordination = static_cast<double>(ends) / particles;
  packing.backbone_coordination = backbone > 0 ? static_cast<double>(backbone_ends) / backbone : 0;
}

double content(const Bodies& bodies) {
  double sum = 0;
  for (const double r : bodies.radius)
    sum += bodies.dimension == 3 ? 4.0 / 3.0 * std::numbers::pi * r * r * r : std::numbers::pi * r * r;
  return sum;
}

/// With V the domain's area (volume): pressure = sum over the sides of force * distance of the opposite one / (d V),
/// and the particles' equilibrium makes that sum one over contacts of force * distance of the centres, or from the
/// wall.
void find_pressure(Packing& packing, const Bodies& bodies, const Scene& scene, double virial) {
  const int d = bodies.dimension;
  const std::array<double, 3> side = {scene.domain.size.x, scene.domain.size.y, scene.domain.height};
  double volume = 1, work = 0;
  for (int k = 0; k < d; ++k) {
    volume *= side[k];
    work += 0.5 * (packing.wall_force[2 * k] + packing.wall_force[2 * k + 1]) * side[k];
  }
  packing.fraction = content(bodies) / volume;
  packing.pressure = work / (d * volume);
  packing.virial_pressure = virial / (d * volume);
}

}  // namespace

Packing packing(const Bodies& bodies, const Scene& scene) {
  const int n = bodies.size();
  const double stiffness = scene.effects.find<effects::ContactPotentialOptions>()->stiffness;
  const effects::ContactPotential potential(stiffness, scene.walls);
  const std::vector<Pair> pairs = pairs_closer_than(bodies, 0);
  Packing packing;
  packing.wall_force.resize(scene.walls.size());
  double virial = 0;
  for (const effects::Overlap& o : potential.overlaps({0, bodies, pairs})) {
    const double force = -stiffness * effects::contact_law(o.q).slope / o.reach;
    virial += force * o.distance;
    if (o.partner >= n) packing.wall_force[o.partner - n] += force;
    packing.smallest_q = std::min(packing.smallest_q, o.q);
    if (o.q < 1 - contact_margin) packing.contacts.push_back({o.particle, o.partner, o.q, o.reach - o.distance, force});
  }
  std::ranges::sort(packing.contacts, {}, [](const PackingContact& c) { return std::pair(c.particle, c.partner); });
  packing.rattler = find_rattlers(packing.contacts, n, bodies.dimension + 1);
  count_contacts(packing, n);
  const bool only_box = scene.domain.walled && scene.walls.size() == 2u * bodies.dimension;
  if (only_box) find_pressure(packing, bodies, scene, virial);
  return packing;
}

}  // namespace lichtenberg::analysis
