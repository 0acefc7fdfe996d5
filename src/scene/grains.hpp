#pragma once

#include "src/scene/draft.hpp"

namespace lichtenberg {

/// Refuses what a scene of grains (with [reference]) cannot have, and what only such a scene can. Throws InputError.
void check_grains(const Draft& draft);

/// Defaults of a scene of grains that are not those of conductors. Called before populations are drawn.
void fill_in_grains(Draft& draft);

/// Defaults of steps, which follow from effects and placed grains.
void fill_in_steps(const Draft& draft, Scene& scene);

/// Charges of the populations, and velocities of those that have a temperature. Throws InputError.
void complete_grains(const Draft& draft, Scene& scene);

}  // namespace lichtenberg
