#pragma once

#include <string>

#include "src/granular/note.hpp"
#include "src/model/motion.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::granular {

/// Returns a warning if the run does not last longer than its stages; else an empty string.
std::string stages_warning(const Scene& scene);

/// Returns the summary of a run that ends with this note. `energy_at_start`: GasEnergy::total at the start.
Summary summarize(Gas& gas, const Note& now, double energy_at_start);

}  // namespace lichtenberg::granular
