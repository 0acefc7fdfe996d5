#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "src/effects/coulomb_sum.hpp"
#include "src/effects/device_forces.hpp"

namespace lichtenberg::effects {
namespace {

/// Chooses the mesh on a device for the requirements in `forces`.
periodic::MeshChoice mesh_on_device(const Scene& scene, const DeviceForces& forces) {
  if (!forces.enclosure.unbounded) return periodic::choose_quick_mesh(forces.enclosure.request(forces.request));
  Vec3 low{INFINITY, INFINITY, INFINITY}, high = -1.0 * low;
  for (const Conductor& grain : scene.conductors)
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], grain.position[k]);
      high[k] = std::max(high[k], grain.position[k]);
    }
  const Vec3 extents = scene.conductors.empty() ? Vec3{} : high - low;
  return periodic::choose_cloud_mesh(extents, forces.request, forces.enclosure);
}

/// Throws InputError for induced dipoles in domains in which a device does not compute them.
void check_dipoles_on_device(const Scene& scene, const periodic::Enclosure& enclosure) {
  if (!scene.effects.has("induced_dipoles")) return;
  if (enclosure.unbounded) refuse_on_device(scene, "effects.induced_dipoles in an unbounded domain");
  if (enclosure.copies() > 1) refuse_on_device(scene, "effects.induced_dipoles between grounded sides");
}

/// Throws InputError if the entries of the device's lists exceed its 32-bit counters.
void check_lists_on_device(const Scene& scene, double cutoff, int copies) {
  const double others = grains_within(scene, cutoff), grains = static_cast<double>(scene.conductors.size()) * copies;
  if (grains * others < std::numeric_limits<int>::max()) return;
  refuse_on_device(scene, fmt::format("lists for {:.0f} grains with {:.0f} others each within {:.2g} d0, which "
                                      "effects.coulomb.accuracy = {:g} requires",
                                      grains, others, cutoff, scene.effects.find<CoulombOptions>()->accuracy));
}

}  // namespace

void coulomb_on_device(const Scene& scene, DeviceForces& forces) {
  const auto& options = *scene.effects.find<CoulombOptions>();
  if (options.sum != CoulombSum::mesh)
    refuse_on_device(scene, fmt::format("effects.coulomb.sum = \"{}\"", name_of(options.sum)));
  if (options.accuracy < 1e-6)
    refuse_on_device(
        scene, fmt::format("effects.coulomb.accuracy = {:g}, its single precision reaches 1e-6", options.accuracy));
  if (options.cutoff || options.alpha || options.mesh || options.order)
    refuse_on_device(scene, "given effects.coulomb.cutoff, alpha, mesh or order");
  forces.enclosure = enclosure_of(scene.domain);
  check_dipoles_on_device(scene, forces.enclosure);
  forces.request = mesh_request(scene);
  forces.request.fixed = {}, forces.request.on_device = true;
  forces.mesh = mesh_on_device(scene, forces);
  const double cutoff = forces.mesh->cutoff + widest_skin,
               n = static_cast<double>(scene.conductors.size()) * forces.enclosure.copies();
  check_lists_on_device(scene, cutoff, forces.enclosure.copies());
  forces.strength = options.strength;
  forces.charged = true;
  // Estimated bytes: lists of partners, and a mesh of integers, points, modes and factors with the transforms' memory.
  const double a_partner = 4, a_column = 4, a_point = forces.mesh->mesh.open.any() ? 32 : 28;
  const auto [x, y, z] = forces.mesh->mesh.points;
  forces.bytes += n * (25 * a_column + 1.25 * a_partner * grains_within(scene, cutoff)) + a_point * x * y * z;
}

}  // namespace lichtenberg::effects
