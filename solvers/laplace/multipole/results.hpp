#pragma once

#include "solvers/laplace/multipole/setting.hpp"

namespace lichtenberg::laplace::multipole {

/// Charges, forces and energy from the coefficients of all sources and, already in the solution, the groups'
/// potentials.
void evaluate(const Setting& setting, const std::vector<Complex>& coefficients, LaplaceSolution& solution);

}  // namespace lichtenberg::laplace::multipole
