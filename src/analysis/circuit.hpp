#pragma once

#include "src/effects/conductor_frame.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::analysis {

/// Computes means over the time between two frames of a scene with a circuit: currents of the terminals (A), powers (W)
/// and entropy production (W/K). They follow from cumulative charges and energies, so that sparks and short currents
/// are included. The structure resistance (ohm) is that between the terminals of highest and lowest source potential;
/// NaN if these are equal. `temperature`: K, of the fluid that absorbs the heat.
CircuitRates circuit_rates(const ConductorFrame& before, const ConductorFrame& now, double temperature);

/// Computes the energy balance of a scene with a circuit (J): stored energy plus heat minus supplied energy since the
/// start. It is constant except for the run's errors.
double energy_account(const ConductorFrame& frame);

/// Returns the relative energy imbalance that discretization errors of a correct run may cause, as a fraction of the
/// supplied energy.
///
/// A coupling step may displace a body by the position tolerance s, which does work F s with the force F. In a step of
/// displacement d, F is extrapolated linearly. If F varies over the smallest radius R, its error is F (d/R)^2. The
/// position error of an overdamped body is then d (d/R)^2 / 2, and the step is chosen so that it equals s.
///
/// The relative error of the work F d of a step is then s/d = (s/R)^(2/3) / 2^(1/3). Charges may have an error of s/R
/// in each step. A body that crosses a gap of R in R/d steps then has the same error again. If all errors have one
/// sign, the sum is 2^(2/3) (s/R)^(2/3). A grid adds the expected error of its forces at the contact gap
/// (solvers/laplace/accuracy). In three dimensions the tolerance of field solves is added instead.
double allowed_energy_imbalance(const Scene& scene);

}  // namespace lichtenberg::analysis
