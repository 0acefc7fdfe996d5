#pragma once

namespace lichtenberg::theory {

/// A wire of equal spheres between two electrodes at +voltage/2 (x = 0) and -voltage/2 (x = length), with one gap
/// somewhere (D 4.3): what is left of the gap is at the left electrode's potential, the rest at the right one's. Each
/// of its conductors + 1 places is as likely as the others.
struct BrokenWire {
  int conductors = 0;
  double radius = 0;        ///< m
  double length = 0;        ///< m, between the electrodes
  double voltage = 0;       ///< V
  double permittivity = 0;  ///< F/m
  double capacitance = 0;   ///< F, of a sphere in the wire: its charge is +-capacitance * voltage / 2

  double whole_gap() const { return length - 2 * conductors * radius; }  ///< m, if it is all in one place
  double mean_gap() const { return whole_gap() / (conductors + 1); }     ///< m, shared by all places (D 4.11)
};

/// Mean force (N) across the wire on conductor i = 1 ... N in a transverse field (V/m), D 4.10:
///   C V E (N + 1 - 2i) / (2 (N + 1)), along E on the positive side.
/// D prints the opposite sign, and 4.8 and 4.9 without the 1/2 that 4.10 has.
double mean_transverse_force(const BrokenWire& wire, int i, double field);

/// Capacitance Q/V (F) of two equal spheres, charges Q and -Q, nearly in contact:
/// pi eps R (ln(4R / gap) + 2 gamma_e), but for terms of the order of gap / R (the sphere before a plane, twice).
double close_spheres_capacitance(double radius, double permittivity, double gap);

/// Their attraction (N) at a given potential difference, V^2/2 dC/dgap = pi eps R V^2 / (2 gap).
double close_spheres_attraction(double radius, double permittivity, double gap, double voltage);

/// D 4.12: Q^2 / (4 pi eps 2 R gap (ln(4R / gap) + 2 gamma_e)^2). For spheres charged with Q and -Q it is 4 times that;
/// with the charges +-C V / 2 of D's wire the two errors cancel, and Q = C V gives the tension 4.13.
double tension(const BrokenWire& wire, double gap);

/// B (1/m^2) of the shape y = B (x - L/2)(L - x) x (D 4.15). In balance, T (y(i+1) - 2 y(i) + y(i-1)) = -F(i) L/(N+1),
/// which is T y'' = -F(x) (N+1) / L in the limit of a long wire:
///   B = -(N + 1) C V E / (6 L^2 T) for a force along E on the left, here with the positive sign of D.
/// D prints 6 C V E / (L^2 T): the 6 misplaced, and N + 1 lost with the spacing in 4.14.
double shape_coefficient(const BrokenWire& wire, double field, double tension);

/// y (m) at x, D 4.15.
double displacement(const BrokenWire& wire, double shape_coefficient, double x);

/// Its largest value (m), at x = L/2 +- L / (2 sqrt 3): B L^3 / (12 sqrt 3) (D 4.16).
double largest_displacement(const BrokenWire& wire, double shape_coefficient);

/// Field (V/m) at which the wire breaks, F sin(theta) = T (D 4.17), with F = C V E / 2 and tan(theta) = y' = slope F /
/// T:
///   E = 2 f T / (C V),  f^2 = 1/2 + sqrt(1/4 + 1 / slope^2).
/// D 4.19 has slope = 24, which gives the 2.002 of 4.20 if sin(theta) = y' / sqrt(1 + y'^2) (4.18 lacks the square).
/// With the right B, y'(0) = (N + 1) F / 6 T.
double critical_field(const BrokenWire& wire, double tension, double slope);
constexpr double printed_slope = 24;
double slope_at_end(const BrokenWire& wire);

/// Where a bent wire gives way by stretching, not in D: its shape is longer than L by half the integral of y'^2,
/// B^2 L^5 / 40, which all gaps share, and their tension falls with gap^-p (p = 1 for spheres, 3/2 for disks). Balance,
/// B (1 + B^2 L^5 / (40 whole_gap))^-p = B_0 with B_0 the B (1/m^2) of the wire with its own tension, has no solution
/// above the B_0 returned. It grows with the transverse field.
double largest_shape_coefficient(const BrokenWire& wire, double p);

/// D 4.21 as printed (V/m), C = 4 pi eps R:
///   2.002 V / (2 (L - 2NR)(N + 1)(ln(4R(N + 1) / (L - 2NR)) + 2 gamma_e)^2).
/// With D's parameters it is 19.6 kV/m, and not the 334 kV/m printed.
double printed_critical_field(const BrokenWire& wire);

}  // namespace lichtenberg::theory
