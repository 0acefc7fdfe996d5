#pragma once

#include "src/scene/draft.hpp"

namespace lichtenberg {

/// The electrodes of a scene. Throws InputError for one that has no extent or lies outside the domain, for two of the
/// same name, and for a short circuit: electrodes that touch each other, or an electrode side of the domain, at another
/// potential.
std::vector<Electrode> build_electrodes(const Draft& draft);

}  // namespace lichtenberg
