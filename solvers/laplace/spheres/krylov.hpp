#pragma once

#include "solvers/laplace/spheres/system.hpp"

namespace lichtenberg::laplace::spheres {

struct KrylovResult {
  int iterations = 0;
  double residual = 0;  ///< relative to the right-hand side and the given charges
};

/// Conjugate gradients (PETSc's, options with the prefix spheres_) from the start x. Throws Failure without
/// convergence.
KrylovResult solve_krylov(const System& system, double tolerance, std::vector<double>& x);

/// Charges over 4 pi eps of the groups (rows) when one of them (columns) is at 1 V and all else at 0: row-major, groups
/// x groups. All groups must be fixed, without couplings. Eight columns are solved for at once. With f_i the columns'
/// right-hand sides, x_i their iterates and r_i = f_i - A x_i, a charge is f_i.x_j + x_i.r_j, whose error r_i.A^-1 r_j
/// is of second order: the iteration ends at about the root of `tolerance`, or at `tolerance` where the columns take
/// too much memory. Throws Failure without convergence.
std::vector<double> unit_charges(const System& system, double tolerance);

}  // namespace lichtenberg::laplace::spheres
