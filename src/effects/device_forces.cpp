#include "src/effects/device_forces.hpp"

#include <fmt/format.h>

#include "solvers/error.hpp"

namespace lichtenberg::effects {

void refuse_on_device(const Scene& scene, const std::string& what) {
  throw InputError(fmt::format("{}: device = \"cuda\" has no {}: \"cpu\" has", scene.path, what));
}

double grains_within(const Scene& scene, double range) {
  const Vec3 lengths = scene.domain.box().lengths;
  return static_cast<double>(scene.conductors.size()) / (lengths.x * lengths.y * lengths.z) * 4.2 * range * range *
         range;
}

}  // namespace lichtenberg::effects
