#pragma once

#include <string>

#include "src/granular/note.hpp"
#include "src/model/motion.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::granular {

/// A warning if stop.time ends the run before its stages have ended, or with them; else nothing.
std::string stages_warning(const Scene& scene);

/// What a run says of a gas that is as in the note. `energy_at_start`: GasEnergy::total then.
Summary summarize(Gas& gas, const Note& now, double energy_at_start);

}  // namespace lichtenberg::granular
