#pragma once

#include "solvers/laplace/spheres/system.hpp"

namespace lichtenberg::laplace::spheres {

/// Charges, dipoles, forces and energy, from the multipoles and the groups' potentials in the solution.
void add_charges_and_forces(const SphereProblem& problem, const std::vector<Site>& sites,
                            const std::vector<double>& multipoles, const WallPotential& wall, SphereSolution& solution);

}  // namespace lichtenberg::laplace::spheres
