#pragma once

#include "solvers/laplace/cutcell/level.hpp"

namespace lichtenberg::laplace {

/// Charges, forces and energy of a solved level. `cell` holds the fluid cells' potentials by slot, in units of `scale`
/// (V); the solution's group_potential is set already. Charge of a body: the sum of its own links' fluxes (D 5.4).
/// Force on a body: virtual work, eps/2 sum over its links of (dV)^2 dc/dx, the closed-form derivative of the energy
/// eps/2 sum c (dV)^2. (The energy itself must not be differenced: it jumps when a cell centre becomes covered.)
void evaluate(const LaplaceProblem& problem, const Level& level, const double* cell, double scale,
              LaplaceSolution& solution, parallel::Team& team = parallel::Team::single());

}  // namespace lichtenberg::laplace
