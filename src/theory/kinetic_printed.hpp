#pragma once

namespace lichtenberg::theory {

/// Functions g_1 ... g_5 of G (5.6-5.8) for grains of mass and diameter 1, C_eps = 1 and C_dq = 1.
struct KineticFunctions {
  double mergers = 0, contact_loss = 0, merging_loss = 0, contact_charge = 0, merging_charge = 0;
};

/// Returns the functions as printed (5.32-5.37 and table 5.1), for comparison only. The printed g_4 would remove charge
/// from an uncharged gas, so the equations cannot be integrated. Throws InputError unless 0 < B < 1, where all are
/// real. `exponent`: exponent of dq as a function of speed.
KineticFunctions printed_functions(double bjerrum, double exponent);

/// Returns the corrected functions, for any B >= 0: the rates of `kinetic_rates` without the factors n, T and <q^2> in
/// front of g_1 ... g_5.
KineticFunctions corrected_functions(double bjerrum, double exponent);

}  // namespace lichtenberg::theory
