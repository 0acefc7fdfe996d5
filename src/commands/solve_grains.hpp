#pragma once

#include "src/commands/json_output.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {

/// Computes and prints forces, potentials and energy of the charges of a scene's grains at the start, in reduced units.
/// Induced dipoles are included. The output is a table or JSON. Throws InputError for a scene without
/// [effects.coulomb].
void solve_grains(const Scene& scene, const JsonTarget& json);

}  // namespace lichtenberg
