#pragma once

#include "src/model/frame.hpp"

namespace lichtenberg::analysis {

/// Means over the time between two frames of a scene with a circuit: differences of what has accumulated, so that no
/// spark or passing charge is missed. `temperature`: K, of the fluid that takes up the heat.
CircuitRates circuit_rates(const Frame& before, const Frame& now, double temperature);

}  // namespace lichtenberg::analysis
