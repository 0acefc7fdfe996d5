#pragma once

#include "src/scene/draft.hpp"

namespace lichtenberg {

/// Throws InputError for [[conductor]]s that touch a body at another potential, unless the contact joins the two. The
/// force across a zero gap is unbounded. `scene` has its conductors, groups and electrodes.
void check_touching(const Draft& draft, const Scene& scene);

}  // namespace lichtenberg
