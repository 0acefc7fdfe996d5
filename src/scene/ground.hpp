#pragma once

#include <string>

#include "src/scene/draft.hpp"

namespace lichtenberg {

/// Checks charge neutrality. Throws InputError if a scene without a fixed potential has a net charge at the first
/// instant, or injected charge and no electrode. A fixed potential is that of a side, an electrode without resistor, a
/// group or infinity (free space). Without one no field line leaves the box, so by Gauss's law the charges must cancel.
/// `source`: the table that injects charge ("effects.current_injection", for example); empty if there is none.
void check_ground(const Draft& draft, const Scene& scene, const std::string& source);

}  // namespace lichtenberg
