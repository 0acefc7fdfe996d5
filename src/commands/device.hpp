#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "src/effects/read_scene.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {

/// `--device`, which comes before the scene's field.device.
inline void add_device_option(CLI::App& command, std::string& device) {
  command.add_option("--device", device, "where the field is solved, cpu or cuda (default: field.device of the scene)")
      ->check(CLI::IsMember({"cpu", "cuda"}));
}

inline Scene read_scene_for(const std::string& path, const std::string& device) {
  Scene scene = read_scene(path);
  if (!device.empty()) scene.field.device = device;
  return scene;
}

}  // namespace lichtenberg
