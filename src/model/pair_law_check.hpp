#pragma once

#include <functional>
#include <string>

#include "src/model/pair_law.hpp"

namespace lichtenberg {

/// Throws InputError if a pair force law contradicts itself. At ten distances between `from` and `cutoff` (m) the force
/// must be minus the derivative of the energy; at one of them it may have a kink. The energy must be 0 at the cutoff.
/// `law`: energy (J) and force (N) at a distance; `name`: name of the effect.
void check_pair_law(const std::function<PairForce(double distance)>& law, double from, double cutoff,
                    const std::string& name);

}  // namespace lichtenberg
