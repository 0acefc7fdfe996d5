#pragma once

#include <fmt/format.h>

#include <string>

#include "src/commands/commands.hpp"
#include "src/commands/streams.hpp"
#include "src/effects/effects.hpp"
#include "src/effects/read_scene.hpp"
#include "src/scene/scene.hpp"
#include "src/scene/stopping.hpp"

namespace lichtenberg {

/// Makes the argument `--device`, which overrides field.device of the scene.
inline Argument device_argument(std::string& device) {
  return {"--device",
          &device,
          "device for the field solver or for grains, cpu or cuda (default: field.device of the scene, cpu for grains)",
          {.allowed = names_of<FieldDevice>()}};
}

/// Returns true if the scene selects a CUDA device.
inline bool is_for_cuda(const Scene& scene) {
  return std::visit([](const auto& field) { return field.device == FieldDevice::cuda; }, scene.field_table);
}

/// Makes the argument `--set` (changed keys of the scene), for commands that read a scene.
inline Argument set_argument(std::vector<std::string>& settings) {
  return {"--set",
          &settings,
          "KEY=VALUE: replaces a key of the scene, as in mechanics.position_tolerance=1e-6 or "
          "electrode[0].potential=2e3; repeat it for other keys",
          {.repeated = true}};
}

/// Parses the values of `--set`, each as KEY=VALUE. Throws InputError for a value of another form.
inline std::vector<Setting> settings_of(const std::vector<std::string>& written) {
  std::vector<Setting> settings;
  for (const std::string& each : written) settings.push_back(setting_of(each));
  return settings;
}

/// Sets the device of the field solver or of the grains. `device`: value of `--device`; empty leaves the scene
/// unchanged.
inline void set_device(Scene& scene, const std::string& device) {
  if (!device.empty())
    std::visit([&](auto& field) { field.device = value_of<FieldDevice>(device).value(); }, scene.field_table);
}

/// Reads a scene with keys changed by `--set` and prints its warnings. `device`: value of `--device`, empty: as in the
/// scene. `stop`: returns true if reading must stop; `bodies`: bodies of a result from which the scene starts
/// (src/scene/stopping.hpp).
inline Scene read_scene_for(const std::string& path, const std::string& device,
                            const std::vector<std::string>& settings, const StopRequest& stop = {},
                            const std::vector<Conductor>& bodies = {}) {
  Scene scene = read_scene(path, effects::all_kinds(), settings_of(settings), stop, bodies);
  for (const std::string& warning : scene.warnings) fmt::print(stderr, "lichtenberg: {}\n", printable(warning));
  set_device(scene, device);
  return scene;
}

}  // namespace lichtenberg
