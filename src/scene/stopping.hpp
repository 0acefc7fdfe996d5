#pragma once

#include <functional>
#include <string>
#include <vector>

#include "src/scene/scene.hpp"

namespace lichtenberg {

/// What ends the reading of a scene where it was told to stop.
struct Stopped {};

/// As read_scene of scene.hpp. `stop` is asked while conductors are placed, which may take minutes; true: throws
/// Stopped.
Scene read_scene(const std::string& path, const EffectKinds& kinds, const std::vector<Setting>& settings,
                 const std::function<bool()>& stop);

}  // namespace lichtenberg
