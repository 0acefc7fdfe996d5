#pragma once

#include <string>

#include "src/scene/draft.hpp"

namespace lichtenberg {

/// Checks charge neutrality: throws InputError if a scene without a fixed potential has charge without a
/// counter-charge. No field line can leave such a box, so by Gauss's law the charges must cancel. An electrode behind a
/// resistor takes up injected charge, but no charge that is present at the first instant. `source`: the table that
/// injects charge ("effects.current_injection", for example); empty if there is none.
void check_ground(const Draft& draft, const Scene& scene, const std::string& source);

}  // namespace lichtenberg
