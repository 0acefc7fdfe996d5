#pragma once

#include <string>
#include <vector>

#include "src/scene/scene.hpp"
#include "src/scene/vary.hpp"

// Functions of src/scene/ with the effects of this program (effects::all_kinds()).

namespace lichtenberg {

Scene read_scene(const std::string& path, const std::vector<Setting>& settings = {});
Scene parse_scene(const std::string& text, const std::string& path);
std::string scene_help(const std::string& part = "");
std::string with_settings(const std::string& text, const std::string& path, const std::vector<Setting>& settings);
void check_values(const std::string& text, const std::string& path, const std::vector<Setting>& settings);

}  // namespace lichtenberg
