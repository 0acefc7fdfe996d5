#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "src/commands/commands.hpp"
#include "src/scene/scene.hpp"
#include "src/scene/stopping.hpp"

namespace lichtenberg {

/// Reads positions and radii of the bodies in a frame of a result (no value: the last), for a scene whose bodies start
/// at these positions (src/scene/stopping.hpp). Throws InputError if the frame does not exist.
std::vector<Conductor> bodies_in(const std::string& result, std::optional<int> frame);

/// Sets the initial positions, velocities and charges of a scene's bodies to those in a frame of a result (no value:
/// the last frame). A [[group]] whose charge the scene prescribes gets the sum of its members' charges. Throws
/// InputError if the frame does not exist or its bodies do not fit the domain. Throws InputError if the result has
/// another number of bodies or is of another kind of scene. Throws Stopped if `stop` requests it while the result's
/// scene is read.
void start_from(const std::string& result, std::optional<int> frame, Scene& scene, const StopRequest& stop = {});

/// Reads a scene whose bodies start from a frame of a result (`--from`, empty: none; `--frame`). `read` reads the scene
/// with these bodies. First reads the result in a child process, because a damaged file may crash it (try_reading()).
/// Throws the exceptions of bodies_in(), start_from() and try_reading(), and InputError for a frame without a result.
Scene read_started(const std::string& result, std::optional<int> frame,
                   const std::function<Scene(const std::vector<Conductor>&)>& read, const StopRequest& stop = {});

/// Makes the arguments `--from` and `--frame`: a result from which the scene starts, and its frame.
std::vector<Argument> from_arguments(std::string& result, std::optional<int>& frame);

}  // namespace lichtenberg
