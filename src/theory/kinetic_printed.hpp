#pragma once

namespace lichtenberg::theory {

/// Dimensionless functions g_1 ... g_5 of the rates in the kinetic theory of the dissertation G (5.6-5.8), for grains
/// of mass and diameter 1. The prefactors of the laws of energy loss and charge transfer are C_eps = 1 and C_dq = 1.
struct KineticFunctions {
  double mergers = 0, contact_loss = 0, merging_loss = 0, contact_charge = 0, merging_charge = 0;
};

/// Computes the functions g_1 ... g_5 as printed in G (5.32-5.37 and table 5.1), for comparison only. The printed g_4
/// would remove charge from an uncharged gas, so the equations cannot be integrated. `bjerrum`: B, the Bjerrum
/// parameter. `exponent`: of the transferred charge as a function of speed. Throws InputError unless 0 < B < 1, where
/// all are real.
KineticFunctions printed_functions(double bjerrum, double exponent);

/// Computes the corrected functions g_1 ... g_5 for any Bjerrum parameter B >= 0, with the arguments of
/// printed_functions(). They are the rates of `kinetic_rates` without the factors n, T and <q^2>.
KineticFunctions corrected_functions(double bjerrum, double exponent);

}  // namespace lichtenberg::theory
