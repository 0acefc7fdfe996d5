#pragma once

#include <vector>

#include "src/scene/draft.hpp"

namespace lichtenberg {

/// Throws InputError for keys that a packing (effects.soft_repulsion) does not allow. In other scenes it throws
/// InputError for keys that require a packing.
void check_packing_keys(const Draft& draft);

/// Makes the walls of a packing (effects.soft_repulsion); none for other scenes. The sides of the domain (left, right,
/// bottom, top; in three dimensions front and back too) come first, if the box has walls. The [[wall]]s follow. Throws
/// InputError for a wall without a direction or with a name that no electrode can have. Throws InputError for two walls
/// of the same name and for a packing without walls.
std::vector<Wall> build_walls(const Draft& draft);

/// Throws InputError for particles of a packing that are on or beyond a wall or have the same position. Also throws if
/// they cannot fit into the domain, alone or together.
void check_packing(const Draft& draft, const Scene& scene);

}  // namespace lichtenberg
