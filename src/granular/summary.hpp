#pragma once

#include "src/granular/note.hpp"
#include "src/model/motion.hpp"

namespace lichtenberg::granular {

/// What a run says of a gas that is as in the note. `energy_at_start`: GasEnergy::total then.
Summary summarize(Gas& gas, const Note& now, double energy_at_start);

}  // namespace lichtenberg::granular
