#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>
#include <vector>

#include "solvers/error.hpp"
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
          "device for the field solver or for grains, cpu or cuda; for grains also cuda:0,1 or cuda:all for several "
          "devices (default: field.device of the scene, cpu for grains)",
          {.offered = names_of<FieldDevice>()}};
}

/// Returns true if the scene selects a CUDA device.
inline bool is_for_cuda(const Scene& scene) {
  return std::visit([](const auto& field) { return field.device == FieldDevice::cuda; }, scene.field_table);
}

/// Parses the part of `--device` after "cuda:": numbers of devices, or "all" (-1). Throws InputError for another text
/// and for a device that is given twice.
inline std::vector<int> cuda_devices_in(const std::string& list) {
  if (list == "all") return {-1};
  std::vector<int> devices;
  for (std::size_t from = 0, comma = 0; comma != std::string::npos; from = comma + 1) {
    comma = list.find(',', from);
    const std::string number = list.substr(from, comma == std::string::npos ? comma : comma - from);
    if (number.empty() || number.size() > 3 || number.find_first_not_of("0123456789") != std::string::npos)
      throw InputError(
          fmt::format("--device cuda:{} is not allowed: it must be a list of device numbers, as in "
                      "cuda:0,1, or cuda:all",
                      list));
    if (std::ranges::count(devices, std::stoi(number)))
      throw InputError(fmt::format("--device cuda:{} is not allowed: it has the device {} twice", list, number));
    devices.push_back(std::stoi(number));
  }
  return devices;
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
/// unchanged. Throws InputError for a value that is not allowed.
inline void set_device(Scene& scene, const std::string& device) {
  if (device.empty()) return;
  const std::size_t colon = device.find(':');
  const auto kind = value_of<FieldDevice>(device.substr(0, colon));
  if (!kind || (colon != std::string::npos && kind != FieldDevice::cuda))
    throw InputError(fmt::format("--device {} is not allowed: it must be {}, or for grains cuda:0,1 or cuda:all",
                                 device, fmt::join(names_of<FieldDevice>(), ", ")));
  if (colon != std::string::npos) scene.cuda_devices = cuda_devices_in(device.substr(colon + 1));
  std::visit([&](auto& field) { field.device = *kind; }, scene.field_table);
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
