#pragma once

#include "solvers/laplace/spheres/system.hpp"

namespace lichtenberg::laplace::spheres {

/// Over 4 pi eps: the force of the local field b = -e on the charges whose multipoles are a,
///   F_z = sum sqrt(l^2 - m^2) a_(l-1),m e_lm,    F_x + i F_y = sum sqrt((l-m)(l-m-1)) conj(a_(l-1),(m+1)) e_lm
/// (the second in complex harmonics): the derivative of the energy at these charges, whether the iteration has found
/// the right ones or not. On a conductor e = a (l > 0).
Vec3 force(const double* multipoles, const double* answer, int degree);

/// Charges, dipoles, forces and energy, from the multipoles and the groups' potentials in the solution. `answer`: the
/// multipoles (l > 0) that would make each sphere a conductor in the field of all others.
void add_charges_and_forces(const SphereProblem& problem, const std::vector<Site>& sites,
                            const std::vector<double>& multipoles, const std::vector<double>& answer,
                            const WallPotential& wall, SphereSolution& solution);

}  // namespace lichtenberg::laplace::spheres
