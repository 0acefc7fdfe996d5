#include "src/analysis/packing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numbers>

#include "src/effects/contact_law.hpp"

namespace lichtenberg::analysis {
namespace {

/// Removes particles with too few contacts repeatedly and returns the removed ones.
std::vector<bool> find_rattlers(const std::vector<PackingContact>& contacts, int particles, int needed) {
  std::vector<std::vector<int>> partners(particles);
  for (const PackingContact& c : contacts) {
    partners[c.particle].push_back(c.partner);
    if (c.partner < particles) partners[c.partner].push_back(c.particle);
  }
  std::vector<int> contact_count(particles), found;
  std::vector<bool> rattler(particles);
  for (int i = 0; i < particles; ++i) {
    contact_count[i] = static_cast<int>(partners[i].size());
    if (contact_count[i] < needed) rattler[i] = true, found.push_back(i);
  }
  while (!found.empty()) {
    const int i = found.back();
    found.pop_back();
    for (const int j : partners[i])
      if (j < particles && !rattler[j] && --contact_count[j] < needed) rattler[j] = true, found.push_back(j);
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

/// Computes the pressure from the walls and from the virial. With V the domain's area (volume), pressure = sum over the
/// sides of force * distance of the opposite side / (d V). In equilibrium of the particles this equals a sum over
/// contacts of force * distance of the centres, or from the wall.
/// Across periodic sides, which have no walls, that sum replaces the force. `virial`: parts of the sum by axis (J).
void find_pressure(Packing& packing, const Bodies& bodies, const Scene& scene, const std::array<double, 4>& virial) {
  const int d = bodies.dimension;
  const Vec3 side = scene.domain.size;
  double volume = 1, work = 0;
  std::size_t wall = 0;
  for (int k = 0; k < d; ++k) {
    volume *= side[k];
    if (bodies.box.periodic(k)) {
      work += virial[k];
    } else {
      work += 0.5 * (packing.wall_force[wall] + packing.wall_force[wall + 1]) * side[k];
      wall += 2;
    }
  }
  packing.fraction = content(bodies) / volume;
  packing.pressure = work / (d * volume);
  packing.virial_pressure = virial[3] / (d * volume);
}

}  // namespace

Packing packing(const Bodies& bodies, const Scene& scene, const effects::SoftRepulsion& potential) {
  const int n = bodies.size();
  const std::vector<Pair> pairs = pairs_closer_than(bodies, 0);
  Packing packing;
  packing.wall_force.resize(scene.walls.size());
  std::array<double, 4> virial{};  // J, by axis, and the sum
  for (const effects::Overlap& o : potential.overlaps({0, bodies, pairs})) {
    const double force = -potential.stiffness() * potential.contact(o.q).slope / o.reach;
    virial[3] += force * o.distance;
    for (int k = 0; k < bodies.dimension; ++k) virial[k] += force * o.distance * o.normal[k] * o.normal[k];
    if (o.partner >= n) packing.wall_force[o.partner - n] += force;
    packing.smallest_q = std::min(packing.smallest_q, o.q);
    if (o.q < 1 - contact_margin) packing.contacts.push_back({o.particle, o.partner, o.q, o.reach - o.distance, force});
  }
  std::ranges::sort(packing.contacts, {}, [](const PackingContact& c) { return std::pair(c.particle, c.partner); });
  packing.rattler = find_rattlers(packing.contacts, n, bodies.dimension + 1);
  count_contacts(packing, n);
  std::size_t sides = 0;
  for (int k = 0; k < bodies.dimension; ++k) sides += bodies.box.periodic(k) ? 0 : 2;
  const bool only_box = (scene.domain.walled || sides == 0) && scene.walls.size() == sides;
  if (only_box) find_pressure(packing, bodies, scene, virial);
  return packing;
}

ColumnGroup columns_of(const Packing& packing) {
  std::vector<std::int32_t> contacts, rattler(packing.rattler.begin(), packing.rattler.end());
  std::vector<double> q, overlap, force;
  for (const PackingContact& contact : packing.contacts) {
    contacts.insert(contacts.end(), {contact.particle, contact.partner});
    q.push_back(contact.q);
    overlap.push_back(contact.overlap);
    force.push_back(contact.force);
  }
  using enum Column::Of;
  return {"packing",
          {{"contacts", "1", list, 2, std::move(contacts)},
           {"q", "1", list, 0, std::move(q)},
           {"overlap", "m", list, 0, std::move(overlap)},
           {"force", "N", list, 0, std::move(force)},
           {"rattler", "1", particles, 0, std::move(rattler)},
           {"wall_force", "N", list, 0, packing.wall_force}}};
}

Summary summarize(const Packing& packing, const Scene& scene) {
  const bool spheres = scene.dimension() == 3;
  Summary summary;
  const auto line = [&](const char* label, std::string text) { summary.lines.push_back({label, std::move(text)}); };
  line("contacts", fmt::format("{}, smallest q {:.4g}", packing.contacts.size(), packing.smallest_q));
  line("coordination", fmt::format("{:.4f}, {:.4f} without the {} rattlers", packing.coordination,
                                   packing.backbone_coordination, packing.rattlers));
  if (packing.fraction) {
    const char* unit = spheres ? "Pa" : "N/m";
    line("filled", fmt::format("{:.4f} of the domain", *packing.fraction));
    line("pressure", fmt::format("{:.6g} {} on the walls, {:.6g} {} from the forces inside", *packing.pressure, unit,
                                 *packing.virial_pressure, unit));
  } else {
    line("pressure", "none, nor how much is filled: there are walls other than the sides of the domain");
  }
  for (std::size_t w = 0; w < scene.walls.size(); ++w)
    line("wall", fmt::format("{:.6g} N on {}", packing.wall_force[w], scene.walls[w].name));
  summary.quantities = {{"contacts", static_cast<double>(packing.contacts.size()), "1"},
                        {"rattlers", static_cast<double>(packing.rattlers), "1"},
                        {"coordination", packing.coordination, "1"},
                        {"backbone_coordination", packing.backbone_coordination, "1"},
                        {"smallest_q", packing.smallest_q, "1"}};
  constexpr double most_overlap = 0.2;  // fraction of the contact distance
  if (1 - packing.smallest_q > most_overlap)
    summary.warnings.push_back(fmt::format(
        "particles overlap by {:.2g} % of their distance in touch: so strong a compression is no packing of "
        "hard particles; fewer or smaller ones overlap less",
        100 * (1 - packing.smallest_q)));
  if (!packing.fraction) return summary;
  const char* unit = spheres ? "Pa" : "N m-1";
  summary.quantities.push_back({"packing_fraction", *packing.fraction, "1"});
  summary.quantities.push_back({"pressure", *packing.pressure, unit});
  summary.quantities.push_back({"virial_pressure", *packing.virial_pressure, unit});
  return summary;
}

}  // namespace lichtenberg::analysis
