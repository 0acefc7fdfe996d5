#pragma once

#include "solvers/laplace/cutcell/level.hpp"

namespace lichtenberg::laplace {

/// Computes the charges of bodies and sides (C/m), the forces on bodies (N/m) and the energy (J/m) from the potentials
/// of a solved grid. `cell`: the fluid cells' potentials by slot (memory index), in units of `scale` (V).
/// `solution.group_potential` must be set. In a slab, sums are those of all processes; torques need an undivided grid.
/// By Gauss's law, the charge of a body is the sum of its links' fluxes (Stephenson 2018, D 5.4). The force is the
/// virtual work eps/2 sum over its links of (dV)^2 dc/dx (c: conductance). It is the closed-form derivative of the
/// energy eps/2 sum c (dV)^2. A difference of energies would be wrong, because the energy jumps when a body covers
/// another cell centre.
void evaluate(const LaplaceProblem& problem, const Level& level, const double* cell, double scale,
              LaplaceSolution& solution, parallel::Team& team = parallel::Team::single());

}  // namespace lichtenberg::laplace
