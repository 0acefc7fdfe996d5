#pragma once

namespace lichtenberg::theory {

/// G's g_1 ... g_5 (5.6-5.8) of grains of mass and diameter 1, C_eps = 1 and C_dq = 1.
struct KineticFunctions {
  double mergers = 0, contact_loss = 0, merging_loss = 0, contact_charge = 0, merging_charge = 0;
};

/// As they are printed (5.32-5.37 and table 5.1), for comparison only: g_4 would take charge away from a gas without
/// any, so no course follows them. Throws InputError unless 0 < B < 1, where all are real. `exponent`: of dq by speed.
KineticFunctions printed_functions(double bjerrum, double exponent);

/// What they ought to be, for any B >= 0: the rates of `kinetic_rates` without the powers of n, T and <q^2> that stand
/// before g_1 ... g_5.
KineticFunctions corrected_functions(double bjerrum, double exponent);

}  // namespace lichtenberg::theory
