#pragma once

namespace lichtenberg::theory {

/// Model of a broken wire: a chain of equal conducting spheres between two electrodes at +voltage/2 (x = 0) and
/// -voltage/2 (x = length), with one gap (Stephenson 2018, D 4.3). Spheres left of the gap have the potential of the
/// left electrode, all others that of the right electrode. The gap is at each of its conductors + 1 positions with
/// equal probability.
struct BrokenWire {
  int conductors = 0;       ///< Number of spheres N
  double radius = 0;        ///< Radius of a sphere (m)
  double length = 0;        ///< Distance of the electrodes (m)
  double voltage = 0;       ///< Voltage between the electrodes (V)
  double permittivity = 0;  ///< Permittivity (F/m)
  double capacitance = 0;   ///< Capacitance of a sphere in the wire (F): its charge is +-capacitance * voltage / 2

  double whole_gap() const { return length - 2 * conductors * radius; }  ///< Total gap (m) at one position
  double mean_gap() const { return whole_gap() / (conductors + 1); }     ///< Mean gap (m) over all positions (D 4.11)
};

/// Computes the mean transverse force (N) on sphere i = 1 ... N of the wire in a transverse field E (V/m), D 4.10:
///
///   C V E (N + 1 - 2i) / (2 (N + 1)), along E on the positive side.
///
/// D prints the opposite sign, and 4.8 and 4.9 lack the 1/2 of 4.10.
double mean_transverse_force(const BrokenWire& wire, int i, double field);

/// Computes the capacitance Q/V (F) of two nearly touching equal spheres with charges Q and -Q: pi eps R (ln(4R / gap)
/// + 2 gamma_e), with Euler's constant gamma_e. The error is of the order of gap / R. The pair is equivalent to two
/// spheres in front of a plane in series.
double close_spheres_capacitance(double radius, double permittivity, double gap);

/// Computes the attraction (N) of two nearly touching equal spheres at a given potential difference V: V^2/2 |dC/dgap|
/// = pi eps R V^2 / (2 gap).
double close_spheres_attraction(double radius, double permittivity, double gap, double voltage);

/// Computes the tension of the wire (N) of D 4.12: Q^2 / (4 pi eps 2 R gap (ln(4R / gap) + 2 gamma_e)^2) with Q = C V.
/// For spheres charged with Q and -Q the correct force is 4 times as large. With the charges +-C V / 2 of the wire in D
/// the two errors cancel, and the result is the tension of D 4.13.
double tension(const BrokenWire& wire, double gap);

/// Computes the coefficient B (1/m^2) of the wire's shape y = B (x - L/2)(L - x) x in a transverse field E (D 4.15),
/// for a tension T. The force balance is T (y(i+1) - 2 y(i) + y(i-1)) = -F(i) L/(N+1), or T y'' = -F(x) (N+1) / L in
/// the limit of a long wire:
///
///   B = -(N + 1) C V E / (6 L^2 T) for a force along E on the left, here with the positive sign of D.
///
/// D prints 6 C V E / (L^2 T): the 6 is misplaced, and N + 1 was lost with the spacing in 4.14.
double shape_coefficient(const BrokenWire& wire, double field, double tension);

/// Computes the displacement y (m) of the wire at x (m), D 4.15.
double displacement(const BrokenWire& wire, double shape_coefficient, double x);

/// Computes the largest displacement of the wire (m), at x = L/2 +- L / (2 sqrt 3): B L^3 / (12 sqrt 3) (D 4.16).
double largest_displacement(const BrokenWire& wire, double shape_coefficient);

/// Computes the transverse field (V/m) at which the wire breaks, F sin(theta) = T (D 4.17). Here F = C V E / 2, and
/// tan(theta) = y' = slope F / T is the slope at the end of the wire:
///
///   E = 2 f T / (C V),  f^2 = 1/2 + sqrt(1/4 + 1 / slope^2).
///
/// D 4.19 has slope = 24, which gives the 2.002 of 4.20 if sin(theta) = y' / sqrt(1 + y'^2) (4.18 lacks the square).
/// With the correct B, y'(0) = (N + 1) F / 6 T.
double critical_field(const BrokenWire& wire, double tension, double slope);
/// Slope in critical_field() as D 4.19 prints it.
constexpr double printed_slope = 24;
/// Computes the correct slope for critical_field(), (N + 1) / 6.
double slope_at_end(const BrokenWire& wire);

/// Computes the largest shape coefficient B_0 (1/m^2) for which a bent wire that stretches has an equilibrium (not in
/// D). B_0 is the coefficient that the wire would have with the tension of the straight wire; it increases with the
/// transverse field.
/// The bent wire is longer than L by half of the integral of y'^2, B^2 L^5 / 40. All gaps share this length, and their
/// tension decreases as gap^-p (p = 1 for spheres, 3/2 for disks). The balance is B (1 + B^2 L^5 / (40 whole_gap))^-p =
/// B_0. It has no solution above the returned value.
double largest_shape_coefficient(const BrokenWire& wire, double p);

/// Computes the critical field (V/m) by D 4.21 as printed, with C = 4 pi eps R:
///
///   2.002 V / (2 (L - 2NR)(N + 1)(ln(4R(N + 1) / (L - 2NR)) + 2 gamma_e)^2).
///
/// With D's parameters it is 19.6 kV/m, not the 334 kV/m printed.
double printed_critical_field(const BrokenWire& wire);

}  // namespace lichtenberg::theory
