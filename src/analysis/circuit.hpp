#pragma once

#include "src/effects/conductor_frame.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::analysis {

/// Means over the time between two frames of a scene with a circuit: differences of what has accumulated, so that no
/// spark or passing charge is missed. `temperature`: K, of the fluid that takes up the heat.
CircuitRates circuit_rates(const ConductorFrame& before, const ConductorFrame& now, double temperature);

/// J: what a scene with a circuit stores and what became heat, less what was supplied. It stays what it was at the
/// start but for the run's errors.
double energy_account(const ConductorFrame& frame);

/// By what fraction of the energy supplied the account of a sound run may move.
///
/// A coupling step may displace a body by position_tolerance s, which does work F s. Step by step F is extrapolated on
/// a straight line; if it varies over a radius R or more (electrics.hpp), a step d leaves F (d/R)^2 over, of which half
/// counts for a body that drag rules (step_control.hpp), so that d (d/R)^2 / 2 = s. Then the work F d of a step is off
/// by s/d = (s/R)^(2/3) / 2^(1/3). Charges may be off by s/R a step, which adds as much again for what crosses a gap of
/// a radius in R/d steps. All with one sign, that is 2^(2/3) (s/R)^(2/3). What the grid adds is as much as its forces
/// are likely to be wrong at the narrowest gap (solvers/laplace/accuracy).
double allowed_energy_imbalance(const Scene& scene);

}  // namespace lichtenberg::analysis
