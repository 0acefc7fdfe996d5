#pragma once

#include "src/commands/json_output.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {

/// Prints forces, potentials and energy of the charges of a scene's grains at the start, including induced dipoles, in
/// reduced units, as a table or as `json`. Throws InputError for a scene without [effects.coulomb].
void solve_grains(const Scene& scene, const JsonTarget& json);

}  // namespace lichtenberg
