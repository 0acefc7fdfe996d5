#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "src/commands/commands.hpp"
#include "src/scene/scene.hpp"
#include "src/scene/stopping.hpp"

namespace lichtenberg {

/// Places and radii of the bodies in a result's frame (empty: the last), for who reads a scene whose bodies start there
/// (src/scene/stopping.hpp). Throws InputError if the result has no such frame.
std::vector<Conductor> bodies_in(const std::string& result, std::optional<int> frame);

/// Puts a scene's bodies where those of a result's frame are (empty: the last), with their velocities and charges, at
/// the time 0. A wire whose charge the scene gives gets that of its members. Throws InputError if the result has no
/// such frame or other bodies than the scene, or the scene's domain has no room for them; Stopped where `stop` says so
/// while the result's scene is read.
void start_from(const std::string& result, std::optional<int> frame, Scene& scene, const StopRequest& stop = {});

/// The scene that `read` makes of such bodies, started from a result (`--from`, empty: none) and its frame (`--frame`).
/// The result is read in a child process first (reading.hpp). Throws InputError as the two above, and for a frame
/// without a result.
Scene read_started(const std::string& result, std::optional<int> frame,
                   const std::function<Scene(const std::vector<Conductor>&)>& read, const StopRequest& stop = {});

/// `--from` and `--frame`.
std::vector<Argument> from_arguments(std::string& result, std::optional<int>& frame);

}  // namespace lichtenberg
