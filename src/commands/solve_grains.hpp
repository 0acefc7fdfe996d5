#pragma once

#include "src/scene/scene.hpp"

namespace lichtenberg {

/// Prints forces, potentials and energy of the charges of a scene's grains at the start, with the dipoles that they
/// induce, in the scene's reduced units: a table, or JSON. Throws InputError for a scene without [effects.coulomb].
void solve_grains(const Scene& scene, bool json);

}  // namespace lichtenberg
