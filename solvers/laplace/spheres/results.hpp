#pragma once

#include "solvers/laplace/spheres/system.hpp"

namespace lichtenberg::laplace::spheres {

/// Computes the force over 4 pi eps on a sphere with the multipoles a in a local field b. The argument `response` is e
/// = -b.
///   F_z = sum sqrt(l^2 - m^2) a_(l-1),m e_lm.
///   F_x + i F_y = sum sqrt((l-m)(l-m-1)) conj(a_(l-1),(m+1)) e_lm, in complex harmonics.
/// The sums have l from 1 to the degree of e. `multipoles`: [harmonics(degree)]; `response`:
/// [harmonics(response_degree)], response_degree <= degree + 1.
/// If e extends one degree beyond a, the force is the negative derivative of the energy at fixed a, converged or not.
/// Without that degree the product of the highest a and its field is missing.
Vec3 force(const double* multipoles, int degree, const double* response, int response_degree);

/// Response multipoles -b of all spheres, for l > 0: the multipoles that would make each sphere a conductor in the
/// field of all other charges.
struct ResponseMultipoles {
  int extra_degrees = 0;       ///< Degrees by which they exceed the spheres' own
  std::vector<double> values;  ///< Layout [sphere][harmonic]
};

/// Computes charges, dipoles, forces, side charges and energy from the `multipoles` (V, [site][harmonic]), and stores
/// them in `solution`. Forces of close-pair corrections and reflections are not included. Needs the group potentials in
/// `solution`.
void add_charges_and_forces(const SphereProblem& problem, const std::vector<Site>& sites,
                            const std::vector<double>& multipoles, const ResponseMultipoles& response,
                            const WallPotential& wall, SphereSolution& solution);

}  // namespace lichtenberg::laplace::spheres
