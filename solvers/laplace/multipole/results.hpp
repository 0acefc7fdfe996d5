#pragma once

#include "solvers/laplace/multipole/setting.hpp"

namespace lichtenberg::laplace::multipole {

/// Computes the charge (C/m) and force (N/m) of each body from the multipole coefficients (V) of all sources, and
/// appends them to `solution`. Forces follow from Blasius' theorem. For a disk centred on a side, both are integrals
/// over the part of its circle in the box.
void evaluate_bodies(const Setting& setting, const std::vector<Complex>& coefficients, LaplaceSolution& solution);

/// Computes the charges of the box's electrode sides (C/m) and the field energy (J/m), and sets them in `solution`.
/// Needs the multipole coefficients (V), and the body charges and group potentials in `solution`.
void evaluate_sides(const Setting& setting, const std::vector<Complex>& coefficients, LaplaceSolution& solution);

}  // namespace lichtenberg::laplace::multipole
