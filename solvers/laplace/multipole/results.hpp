#pragma once

#include "solvers/laplace/multipole/setting.hpp"

namespace lichtenberg::laplace::multipole {

/// Appends the bodies' charges and forces, computed from the coefficients of all sources.
void evaluate_bodies(const Setting& setting, const std::vector<Complex>& coefficients, LaplaceSolution& solution);

/// Sets the sides' charges and the energy, computed from the coefficients and from the body and group results.
void evaluate_sides(const Setting& setting, const std::vector<Complex>& coefficients, LaplaceSolution& solution);

}  // namespace lichtenberg::laplace::multipole
