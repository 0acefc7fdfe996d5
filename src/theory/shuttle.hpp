#pragma once

#include <functional>

namespace lichtenberg::theory {

/// One sphere that carries charge to and fro between two electrodes at +voltage/2 and -voltage/2 (D 4.2). The
/// electrodes act like spheres of its own radius: at rest against one of them, its centre is 2 R from the electrode's.
struct SphereShuttle {
  double radius = 0;        ///< m
  double gap = 0;           ///< m: its way from electrode to electrode (D's g)
  double voltage = 0;       ///< V: their potential difference
  double permittivity = 0;  ///< F/m
  double drag = 0;          ///< kg/s: force over speed (D's gamma)
  double capacitance = 0;   ///< F: of the sphere and of each electrode, charge over potential
};

/// 4 pi eps R (F): of a sphere far from everything (below D 4.20).
double isolated_sphere_capacitance(double radius, double permittivity);

/// Force (N) toward the electrode ahead at x (m, from the middle of the way): charges +-C V / 2 on sphere and
/// electrodes, attracted and repelled over a/2 -+ x, a = g + 4R, as point charges,
///   F = 2 (C V)^2 / (4 pi eps) (a^2 + 4 x^2) / (a^2 - 4 x^2)^2.
/// D 4.3 prints the denominator without its square.
double monopole_force(const SphereShuttle& shuttle, double x);

/// Time (s) from electrode to electrode without inertia, gamma dx/dt = F:
///   t = 4 C/A (a^3 atan(g / a) - (2/3) g (g + 3R)(g + 6R)),  A = 2 C^3 V^2 / (4 pi eps gamma).
/// D 4.4 prints it without the 4.
double crossing_time(const SphereShuttle& shuttle);

/// Mean current (A), D 4.2. Each contact turns -C V / 2 into C V / 2, so C V passes every second crossing: C V / 2t.
double mean_current(const SphereShuttle& shuttle);

/// Resistance of the gap (Ohm): voltage / mean_current = 2 t / C. D 4.6 prints 1/8 of it (for the factor 4 of the
/// crossing time and a charge of C V instead of C V / 2), and fits A. It falls with voltage^2 (D 4.7).
double resistance(const SphereShuttle& shuttle);

/// Charge (C) of a sphere that touches a plate in the homogeneous field (V/m) before it: 2/3 pi^3 eps R^2 E
/// (Maxwell's Treatise, art. 175; Lebedev and Skal'skaya, Sov. Phys. Tech. Phys. 7, 268 (1962)).
double sphere_on_plate_charge(double radius, double permittivity, double field);

/// Time (s) from x = `from` to `to` (m) at the speed force(x) / drag: without inertia.
double overdamped_time(const std::function<double(double)>& force, double drag, double from, double to);

/// Time (s) from x = `from` to `to` (m) at one constant speed, kept up by elastic reflection at both ends: inertia in
/// command. The force's work is what drag dissipates, drag v (to - from). Never longer than without inertia: the mean
/// of a force is at least its harmonic mean.
double ballistic_time(const std::function<double(double)>& force, double drag, double from, double to);

}  // namespace lichtenberg::theory
