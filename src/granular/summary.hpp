#pragma once

#include <string>

#include "src/granular/note.hpp"
#include "src/model/motion.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::granular {

/// Returns a warning if the run is not longer than its stages of equilibration; otherwise an empty string.
std::string stages_warning(const Scene& scene);

/// Returns the summary of a run of grains: lines of text, numbers and warnings. `now`: observables at its end;
/// `energy_at_start`: GasEnergy::total() at the start (m0 v0^2).
Summary summarize(Gas& gas, const Note& now, double energy_at_start);

}  // namespace lichtenberg::granular
