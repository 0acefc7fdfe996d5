#pragma once

#include "src/scene/draft.hpp"

namespace lichtenberg {

/// Throws InputError for a [[conductor]] that touches another [[conductor]], an electrode or an electrode side. Contact
/// is allowed within a group and between bodies of one prescribed potential. The force across a zero gap between two
/// potentials is unbounded. The check is for scenes without contact_discharge, which joins touching bodies. `scene` has
/// its conductors, groups and electrodes.
void check_touching(const Draft& draft, const Scene& scene);

}  // namespace lichtenberg
