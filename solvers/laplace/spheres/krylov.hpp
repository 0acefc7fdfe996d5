#pragma once

#include "solvers/laplace/spheres/system.hpp"

namespace lichtenberg::laplace::spheres {

/// Number of iterations of solve_krylov() and the residual that it reached.
struct KrylovResult {
  int iterations = 0;
  double residual = 0;            ///< Relative to the norm of the right-hand side and the given charges
  double eigenvalue = 1;          ///< Smallest eigenvalue of the preconditioned matrix that the iteration found
  std::vector<double> product{};  ///< Product of the matrix with x (System::apply)
};

/// Solves the linear system by preconditioned conjugate gradients (PETSc, options with the prefix spheres_). On entry x
/// is the initial guess with the given charges, on return the solution. `tolerance`: norm of the residual, relative to
/// the right-hand side and the given charges; rounding limits it. Throws Failure if the iteration does not converge.
KrylovResult solve_krylov(const System& system, double tolerance, std::vector<double>& x);

/// Computes the capacitance matrix over 4 pi eps: the charges of the groups (rows) with one group (columns) at 1 V and
/// all else at 0; row-major, groups x groups. All groups of the system must be fixed, without couplings.
/// Eight columns are solved at once. With f_i the columns' right-hand sides, x_i their iterates and r_i = f_i - A x_i,
/// a charge is f_i.x_j + x_i.r_j, with an error r_i.A^-1 r_j of second order. The iteration therefore ends at about the
/// root of `tolerance`, or at `tolerance` if the columns take too much memory. Throws Failure if it does not converge.
std::vector<double> unit_charges(const System& system, double tolerance);

}  // namespace lichtenberg::laplace::spheres
