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
/// there (src/scene/stopping.hpp). Throws InputError if the frame does not exist.
std::vector<Conductor> bodies_in(const std::string& result, std::optional<int> frame);

/// Sets the positions, velocities and charges of a scene's bodies to those of a frame of a result (no value: the last),
/// at time 0. A [[group]] whose charge the scene prescribes gets the sum of its members' charges. Throws InputError if
/// the frame does not exist, or the bodies differ from the scene's or do not fit its domain. Throws Stopped if `stop`
/// requests it while the result's scene is read.
void start_from(const std::string& result, std::optional<int> frame, Scene& scene, const StopRequest& stop = {});

/// Reads a scene whose bodies start from a frame of a result (`--from`, empty: none; `--frame`). `read` reads the scene
/// with these bodies. First reads the result in a child process (reading.hpp). Throws InputError as the functions
/// above, and for a frame without a result.
Scene read_started(const std::string& result, std::optional<int> frame,
                   const std::function<Scene(const std::vector<Conductor>&)>& read, const StopRequest& stop = {});

/// Makes the arguments `--from` and `--frame`: a result from which the scene starts, and its frame.
std::vector<Argument> from_arguments(std::string& result, std::optional<int>& frame);

}  // namespace lichtenberg
