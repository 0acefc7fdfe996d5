#pragma once

#include <vector>

#include "src/scene/draft.hpp"

namespace lichtenberg {

/// Refuses what only a scene with effects.contact_potential may have, or what such a scene may not.
void check_packing_keys(const Draft& draft);

/// The walls of a scene with a contact potential: the sides of the domain (left, right, bottom, top; in three
/// dimensions front and back too) if its box is one of walls, then the [[wall]]s. Throws InputError
/// for a wall without a direction or with a name that no electrode can have, for two of the same name, and for a
/// packing without any.
std::vector<Wall> build_walls(const Draft& draft);

/// Refuses particles that are beyond a wall, that lie at one place or that cannot fit into the domain together.
void check_packing(const Draft& draft, const Scene& scene);

}  // namespace lichtenberg
