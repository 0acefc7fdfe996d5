#pragma once

#include "solvers/laplace/multipole/arrangement.hpp"
#include "solvers/laplace/multipole/near_field.hpp"
#include "solvers/laplace/multipole/wall_field.hpp"

namespace lichtenberg::laplace {

/// Charges, forces and energy from the multipole coefficients of each body and, already in the solution, the groups'
/// potentials.
void evaluate(const LaplaceProblem& problem, const Mirrors& mirrors, const LatticeSum& lattice, const WallField& wall,
              const Arrangement& arrangement, const std::vector<Complex>& coefficients, LaplaceSolution& solution);

}  // namespace lichtenberg::laplace
