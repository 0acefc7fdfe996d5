#pragma once

#include "src/scene/draft.hpp"

namespace lichtenberg {

/// Throws InputError for keys that a scene of grains (with [units]) does not allow, and for keys that require one.
void check_grains(const Draft& draft);

/// Fills in the defaults of a scene of grains that differ from those of conductors. Called before populations are
/// drawn.
void fill_in_grains(Draft& draft);

/// Fills in defaults of steps, which depend on effects and placed grains.
void fill_in_steps(const Draft& draft, Scene& scene);

/// Sets the charges of the populations, and the velocities of populations that have a temperature. Throws InputError
/// for keys of charges that contradict each other, and for too many grains for the integrator. Throws InputError for a
/// domain shorter than two diameters, and for a stage too short for the rounding of time.
void complete_grains(const Draft& draft, Scene& scene);

}  // namespace lichtenberg
