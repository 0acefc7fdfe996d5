#pragma once

#include "src/effects/conductor_frame.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::analysis {

/// Returns means over the time between two frames of a scene with a circuit. They are differences of cumulative
/// quantities, so that sparks and short currents are included. `temperature`: K, of the fluid that absorbs the heat.
CircuitRates circuit_rates(const ConductorFrame& before, const ConductorFrame& now, double temperature);

/// Returns the stored energy plus the heat minus the supplied energy (J) of a scene with a circuit. Except for the
/// run's errors it is constant.
double energy_account(const ConductorFrame& frame);

/// Returns the energy imbalance that a sound run may have, as a fraction of the supplied energy.
///
/// A coupling step may displace a body by position_tolerance s, which does work F s. In each step, F is extrapolated
/// linearly. If F varies over a length R or more (electrics.hpp), a step of displacement d leaves an error F (d/R)^2.
/// Half of it counts for an overdamped body (step_control.hpp), so that d (d/R)^2 / 2 = s.
///
/// The relative error of the work F d of a step is then s/d = (s/R)^(2/3) / 2^(1/3). Charges may have an error of s/R
/// in each step, which adds the same amount for a body that crosses a gap of a radius in R/d steps. If all errors have
/// one sign, the sum is 2^(2/3) (s/R)^(2/3). The grid adds the expected error of its forces at the narrowest gap
/// (solvers/laplace/accuracy).
double allowed_energy_imbalance(const Scene& scene);

}  // namespace lichtenberg::analysis
