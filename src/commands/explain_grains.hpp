#pragma once

#include "src/scene/scene.hpp"

namespace lichtenberg {

/// Prints how the motion of a scene of grains is computed (steps, contacts, sums of forces), the predictions of theory
/// and the cost.
void explain_grains(const Scene& scene);

}  // namespace lichtenberg
