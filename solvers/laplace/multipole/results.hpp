#pragma once

#include "solvers/laplace/multipole/setting.hpp"

namespace lichtenberg::laplace::multipole {

/// Adds the bodies' charges and forces, from the coefficients of all sources.
void evaluate_bodies(const Setting& setting, const std::vector<Complex>& coefficients, LaplaceSolution& solution);

/// Charges of the sides and the energy, from these and what the solution has of bodies and groups.
void evaluate_sides(const Setting& setting, const std::vector<Complex>& coefficients, LaplaceSolution& solution);

}  // namespace lichtenberg::laplace::multipole
