#pragma once

#include <functional>
#include <string>
#include <vector>

#include "solvers/stop.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {

/// Function that is called while conductors are placed, which may take minutes. If it returns true, Stopped is thrown.
/// May be empty.
using StopRequest = std::function<bool()>;

/// Reads and checks a scene file as read_scene of scene.hpp does, and throws Stopped if `stop` returns true. `bodies`:
/// bodies of a result from which the scene starts. The conductors then take the positions and radii of `bodies`. Empty:
/// positions are those of the file or drawn. Throws InputError if the numbers of bodies differ, or if a body has a
/// radius that it cannot have in the scene.
Scene read_scene(const std::string& path, const EffectKinds& kinds, const std::vector<Setting>& settings,
                 const StopRequest& stop, const std::vector<Conductor>& bodies = {});
/// Reads and checks a scene from text in memory, otherwise as the function read_scene with `stop` and `bodies`; `path`
/// is used in messages.
Scene parse_scene(const std::string& text, const std::string& path, const EffectKinds& kinds,
                  const std::vector<Setting>& settings, const StopRequest& stop,
                  const std::vector<Conductor>& bodies = {});

}  // namespace lichtenberg
