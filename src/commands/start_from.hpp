#pragma once

#include <optional>
#include <string>

#include "src/scene/scene.hpp"
#include "src/scene/stopping.hpp"

namespace lichtenberg {

/// Puts a scene's bodies where those of a result's frame are (empty: the last), with their velocities and charges, at
/// the time 0. A wire whose charge the scene gives gets that of its members. Throws InputError if the result has no
/// such frame or other bodies than the scene; Stopped where `stop` says so while the result's scene is read.
void start_from(const std::string& result, std::optional<int> frame, Scene& scene, const StopRequest& stop = {});

}  // namespace lichtenberg
