#pragma once

#include "solvers/laplace/spheres/system.hpp"

namespace lichtenberg::laplace::spheres {

/// Force over 4 pi eps of the local field b = -answer on charges with the multipoles a:
///   F_z = sum sqrt(l^2 - m^2) a_(l-1),m e_lm,    F_x + i F_y = sum sqrt((l-m)(l-m-1)) conj(a_(l-1),(m+1)) e_lm
/// (the second in complex harmonics), l from 1 to the degree of the answer e: the negative derivative of the energy at
/// fixed a, converged or not, if e reaches one degree beyond a. Without that last degree the product of the highest a
/// and its field is missing.
/// `multipoles`: [harmonics(degree)], `answer`: [harmonics(answer_degree)], answer_degree <= degree + 1.
Vec3 force(const double* multipoles, int degree, const double* answer, int answer_degree);

/// The multipoles (l > 0) that would make each sphere a conductor in the field of all others, by sphere.
struct Answer {
  int beyond = 0;              ///< degrees by which it exceeds the spheres' own
  std::vector<double> values;  ///< [sphere][harmonic]
};

/// Charges, dipoles, forces and energy, from the multipoles and the groups' potentials in the solution.
void add_charges_and_forces(const SphereProblem& problem, const std::vector<Site>& sites,
                            const std::vector<double>& multipoles, const Answer& answer, const WallPotential& wall,
                            SphereSolution& solution);

}  // namespace lichtenberg::laplace::spheres
