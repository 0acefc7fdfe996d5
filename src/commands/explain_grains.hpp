#pragma once

#include "src/commands/explanation.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {

/// Prints the units of a scene of grains, its filling, and its total momentum and charge. Prints how its motion is
/// computed (stages, steps, contacts), the memory, the predictions of theory and the cost.
void explain_grains(Explanation& out, const Scene& scene);

}  // namespace lichtenberg
