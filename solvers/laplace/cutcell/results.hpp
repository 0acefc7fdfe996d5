#pragma once

#include "solvers/laplace/cutcell/level.hpp"

namespace lichtenberg::laplace {

/// Computes charges, forces and energy of a solved level. `cell`: the fluid cells' potentials by slot, in units of
/// `scale` (V). The solution's group_potential must be set. The charge of a body is the sum of its links' fluxes (D
/// 5.4). The force is the virtual work eps/2 sum over its links of (dV)^2 dc/dx, the closed-form derivative of the
/// energy eps/2 sum c (dV)^2. A difference of energies would be wrong, because the energy jumps when a body covers
/// another cell centre.
void evaluate(const LaplaceProblem& problem, const Level& level, const double* cell, double scale,
              LaplaceSolution& solution, parallel::Team& team = parallel::Team::single());

}  // namespace lichtenberg::laplace
