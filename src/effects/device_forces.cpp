#include "src/effects/device_pair.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "solvers/error.hpp"

namespace lichtenberg::effects {

void refuse_on_device(const Scene& scene, const std::string& what) {
  throw InputError(fmt::format("{}: device = \"cuda\" does not support {}: use device = \"cpu\"", scene.path, what));
}

double grains_within(const Scene& scene, double range) {
  const Vec3 lengths = scene.domain.box().lengths;
  return static_cast<double>(scene.conductors.size()) / (lengths.x * lengths.y * lengths.z) * 4.2 * range * range *
         range;
}

PairGeometry strongest_pair(const Scene& scene, double reach) {
  double charge = 1;
  for (const Conductor& grain : scene.conductors) charge = std::max(charge, std::abs(grain.charge));
  const double radius = scene.smallest_radius();
  return {2 * radius, reach, radius, radius, charge, charge};
}

void add_pair_lists(const Scene& scene, double reach, DeviceForces& forces) {
  const Vec3 lengths = scene.domain.box().lengths;
  const double most = 0.5 * std::min({lengths.x, lengths.y, lengths.z});
  if (reach > most)
    refuse_on_device(scene,
                     fmt::format("forces that reach {:g} d0, beyond half of the shortest side, {:g} d0", reach, most));
  constexpr double a_grain = 40, a_partner = 4;
  forces.bytes += static_cast<double>(scene.conductors.size()) *
                  (a_grain + 1.25 * a_partner * grains_within(scene, reach + widest_skin));
}

}  // namespace lichtenberg::effects
