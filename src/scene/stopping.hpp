#pragma once

#include <functional>
#include <string>
#include <vector>

#include "src/scene/scene.hpp"

namespace lichtenberg {

/// What ends the reading of a scene where it was told to stop.
struct Stopped {};

/// Asked while conductors are placed, which may take minutes; true: Stopped is thrown. May be empty.
using StopRequest = std::function<bool()>;

/// As read_scene and parse_scene of scene.hpp, but for what `stop` ends. `bodies`: those of a result, where the scene's
/// start; then no places are drawn, and all conductors have the places and radii of these. Empty: places are drawn.
/// Throws InputError if there are not as many, or one has a radius that the scene does not give it.
Scene read_scene(const std::string& path, const EffectKinds& kinds, const std::vector<Setting>& settings,
                 const StopRequest& stop, const std::vector<Conductor>& bodies = {});
Scene parse_scene(const std::string& text, const std::string& path, const EffectKinds& kinds,
                  const std::vector<Setting>& settings, const StopRequest& stop,
                  const std::vector<Conductor>& bodies = {});

}  // namespace lichtenberg
