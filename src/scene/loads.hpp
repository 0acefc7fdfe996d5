#pragma once

#include "src/scene/draft.hpp"

namespace lichtenberg {

/// Throws InputError for keys of [compression] that contradict each other or the rest of the file, and for the table in
/// a scene without a packing.
void check_load_keys(const Draft& draft);

/// Returns the axis along which the plate of [compression] moves (0: x); -1 if all sides move.
int plate_axis(const CompressionOptions& compression);

/// Returns the total area or volume of the particles over that of the domain. Overlaps count twice.
double packing_fraction(const Scene& scene);

/// Returns the packing in a domain of another size (m): its walls move with the sides, and positions are scaled.
Scene resized(Scene scene, Vec3 size);

}  // namespace lichtenberg
