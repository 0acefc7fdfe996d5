#pragma once

#include "solvers/laplace/spheres/system.hpp"

namespace lichtenberg::laplace::spheres {

/// Charges, dipoles, forces and energy, from the multipoles and the groups' potentials in the solution. `answer`: the
/// multipoles (l > 0) that would make each sphere a conductor in the field of all others.
void add_charges_and_forces(const SphereProblem& problem, const std::vector<Site>& sites,
                            const std::vector<double>& multipoles, const std::vector<double>& answer,
                            const WallPotential& wall, SphereSolution& solution);

}  // namespace lichtenberg::laplace::spheres
