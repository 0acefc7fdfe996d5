#pragma once

#include <string>

#include "src/commands/commands.hpp"
#include "src/effects/read_scene.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {

/// `--device`, which comes before the scene's field.device.
inline Argument device_argument(std::string& device) {
  return {
      "--device",
      &device,
      "where the field is solved or grains are moved, cpu or cuda (default: field.device of the scene, cpu for grains)",
      {.allowed = names_of<FieldDevice>()}};
}

inline bool is_for_cuda(const Scene& scene) {
  return std::visit([](const auto& field) { return field.device == FieldDevice::cuda; }, scene.field_table);
}

inline Scene read_scene_for(const std::string& path, const std::string& device) {
  Scene scene = read_scene(path);
  if (!device.empty())
    std::visit([&](auto& field) { field.device = value_of<FieldDevice>(device).value(); }, scene.field_table);
  return scene;
}

}  // namespace lichtenberg
