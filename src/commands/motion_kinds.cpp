#include "src/commands/device.hpp"
#include "src/commands/motion_kind.hpp"
#include "src/granular/device/device.hpp"
#include "src/granular/granular_motion.hpp"
#include "src/granular/summary.hpp"
#include "src/scene/effect_kind.hpp"
#include "src/statics/compression.hpp"

namespace lichtenberg {
namespace {

MotionKind packing_minimization() {
  return {.takes = [](const Scene& scene) { return scene.effects.has(&EffectKind::packing); },
          .make = [](const Scene& scene) -> std::unique_ptr<Motion> {
            if (scene.compression.loads() > 0) return std::make_unique<Compression>(scene);
            return std::make_unique<Minimization>(scene);
          },
          .check_device = check_field_device};
}

MotionKind grain_motion() {
  return {.takes = [](const Scene& scene) { return scene.reference.has_value(); },
          .make = [](const Scene& scene) -> std::unique_ptr<Motion> {
            return std::make_unique<GranularMotion>(
                scene, is_for_cuda(scene)
                           ? granular::device::make_cuda_gas(scene, granular::device::chosen_devices(scene))
                           : nullptr);
          },
          .check_device =
              [](const Scene& scene) {
                if (!is_for_cuda(scene)) return;
                const auto devices = granular::device::chosen_devices(scene);
                granular::device::check_scene(scene, granular::device::Target::cuda, static_cast<int>(devices.size()));
              },
          .warning = granular::stages_warning};
}

}  // namespace

const std::vector<MotionKind>& motion_kinds() {
  static const std::vector<MotionKind> kinds = {packing_minimization(), grain_motion(),
                                                conductor_motion()};  // last, because it takes each scene
  return kinds;
}

}  // namespace lichtenberg
