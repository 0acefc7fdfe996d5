#include "src/effects/read_scene.hpp"

#include "src/effects/effects.hpp"

namespace lichtenberg {

using effects::all_kinds;

Scene read_scene(const std::string& path, const std::vector<Setting>& settings) {
  return read_scene(path, all_kinds(), settings);
}

Scene parse_scene(const std::string& text, const std::string& path) { return parse_scene(text, path, all_kinds()); }

std::string scene_help(const std::string& part) { return scene_help(all_kinds(), part); }

std::string with_settings(const std::string& text, const std::string& path, const std::vector<Setting>& settings) {
  return with_settings(text, path, settings, all_kinds());
}

void check_values(const std::string& text, const std::string& path, const std::vector<Setting>& settings) {
  check_values(text, path, settings, all_kinds());
}

}  // namespace lichtenberg
