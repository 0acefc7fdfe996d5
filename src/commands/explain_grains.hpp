#pragma once

#include "src/scene/scene.hpp"

namespace lichtenberg {

/// Says how the motion of a scene of grains will be computed, what its theory expects of it and what it costs.
void explain_grains(const Scene& scene);

}  // namespace lichtenberg
