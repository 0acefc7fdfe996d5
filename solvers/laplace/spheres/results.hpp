#pragma once

#include "solvers/laplace/spheres/system.hpp"

namespace lichtenberg::laplace::spheres {

/// Returns the force over 4 pi eps of the local field b = -response on charges with the multipoles a:
///   F_z = sum sqrt(l^2 - m^2) a_(l-1),m e_lm,
///   F_x + i F_y = sum sqrt((l-m)(l-m-1)) conj(a_(l-1),(m+1)) e_lm
/// (the second in complex harmonics), with e the response and l from 1 to its degree. If e extends one degree beyond a,
/// this is the negative derivative of the energy at fixed a, converged or not. Without that last degree the product of
/// the highest a and its field is missing. `multipoles`: [harmonics(degree)], `response`: [harmonics(response_degree)],
/// response_degree <= degree + 1.
Vec3 force(const double* multipoles, int degree, const double* response, int response_degree);

/// Response multipoles: those (l > 0) that would make each sphere a conductor in the field of all others.
struct ResponseMultipoles {
  int extra_degrees = 0;       ///< Degrees by which they exceed the spheres' own
  std::vector<double> values;  ///< Layout [sphere][harmonic]
};

/// Sets charges, dipoles, forces and energy, from the multipoles and the groups' potentials in the solution.
void add_charges_and_forces(const SphereProblem& problem, const std::vector<Site>& sites,
                            const std::vector<double>& multipoles, const ResponseMultipoles& response,
                            const WallPotential& wall, SphereSolution& solution);

}  // namespace lichtenberg::laplace::spheres
