#pragma once

#include "src/scene/draft.hpp"

namespace lichtenberg {

/// Refuses conductors given one by one that touch something at another potential: if nothing makes them one with it,
/// the force across a gap of zero has no limit. `scene` has its conductors, groups and electrodes.
void check_touching(const Draft& draft, const Scene& scene);

}  // namespace lichtenberg
