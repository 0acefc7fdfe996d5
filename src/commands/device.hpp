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
          "device for the field solver or for grains, cpu or cuda; also cuda:0,1 or cuda:all for several "
          "devices (default: field.device of the scene, cpu for grains)",
          {.offered = names_of<FieldDevice>()}};
}

/// Returns true if the scene selects a CUDA device.
inline bool is_for_cuda(const Scene& scene) {
  return std::visit([](const auto& field) { return field.device == FieldDevice::cuda; }, scene.field_table);
}

/// Device of the field solver or of the grains, and numbers of CUDA devices as in Scene::cuda_devices.
struct ChosenDevice {
  FieldDevice device;
  std::vector<int> cuda_devices;
};

/// Parses the value of `--device`. Throws InputError for a value that is not allowed, and for a device that is given
/// twice.
inline ChosenDevice device_from(const std::string& written) {
  if (const auto device = value_of<FieldDevice>(written)) return {*device, {}};
  const std::string prefix = "cuda:", list = written.starts_with(prefix) ? written.substr(prefix.size()) : "";
  if (list == "all") return {FieldDevice::cuda, {-1}};
  ChosenDevice chosen{FieldDevice::cuda, {}};
  for (std::size_t from = 0, comma = 0; comma != std::string::npos; from = comma + 1) {
    comma = list.find(',', from);
    const std::string number = list.substr(from, comma == std::string::npos ? comma : comma - from);
    if (number.empty() || number.size() > 3 || number.find_first_not_of("0123456789") != std::string::npos)
      throw InputError(
          fmt::format("--device {} is not allowed: it must be {}, or for several devices cuda:0,1 or cuda:all", written,
                      fmt::join(names_of<FieldDevice>(), ", ")));
    if (std::ranges::count(chosen.cuda_devices, std::stoi(number)))
      throw InputError(fmt::format("--device {} is not allowed: it has the device {} twice", written, number));
    chosen.cuda_devices.push_back(std::stoi(number));
  }
  return chosen;
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

/// Sets the device of the field solver or of the grains. `written`: value of `--device`; empty leaves the scene
/// unchanged. Throws InputError for a value that is not allowed, and for a list of devices that the field solver does
/// not support.
inline void set_device(Scene& scene, const std::string& written) {
  if (written.empty()) return;
  const ChosenDevice chosen = device_from(written);
  scene.cuda_devices = chosen.cuda_devices;
  std::visit([&](auto& field) { field.device = chosen.device; }, scene.field_table);
  if (scene.reference || chosen.cuda_devices.empty()) return;
  if (std::ranges::any_of(chosen.cuda_devices, [](int number) { return number > 63; }))
    throw InputError(fmt::format("{}: --device {} has a number above 63", scene.path, written));
  if (chosen.cuda_devices.size() == 1 && chosen.cuda_devices.front() >= 0)
    throw InputError(
        fmt::format("{}: --device {} is for grains only: a field needs --device cuda, without numbers, or "
                    "several devices, as in --device cuda:0,1",
                    scene.path, written));
  std::visit(
      [&](auto& field) {
        if (field.linear_solver != FieldLinearSolver::multigrid)
          throw InputError(
              fmt::format("{}: --device {} needs field.linear_solver = \"multigrid\": an assembled matrix "
                          "is on one device, --device cuda",
                          scene.path, written));
        field.cuda_devices = chosen.cuda_devices;
      },
      scene.field_table);
}

/// Reads a scene with keys changed by `--set` and prints its warnings. `device`: value of `--device`, empty: as in the
/// scene. `stop`: returns true if reading must stop; `bodies`: bodies of a result from which the scene starts
/// (src/scene/stopping.hpp).
inline Scene read_scene_for(const std::string& path, const std::string& device,
                            const std::vector<std::string>& settings, const StopRequest& stop = {},
                            const std::vector<Conductor>& bodies = {}) {
  if (!device.empty()) device_from(device);  // Throws before the scene is read, which may take minutes.
  Scene scene = read_scene(path, effects::all_kinds(), settings_of(settings), stop, bodies);
  for (const std::string& warning : scene.warnings) fmt::print(stderr, "lichtenberg: {}\n", printable(warning));
  set_device(scene, device);
  return scene;
}

}  // namespace lichtenberg
