#pragma once

#include <functional>

namespace lichtenberg::theory {

/// One sphere that transports charge back and forth between two electrodes at +voltage/2 and -voltage/2 (D 4.2). The
/// electrodes act like spheres of the same radius. If the sphere is at rest against one of them, its centre is 2 R from
/// the electrode's.
struct SphereShuttle {
  double radius = 0;        ///< m
  double gap = 0;           ///< m: displacement from electrode to electrode (D's g)
  double voltage = 0;       ///< V: potential difference of the electrodes
  double permittivity = 0;  ///< F/m
  double drag = 0;          ///< kg/s: force over speed (D's gamma)
  double capacitance = 0;   ///< F: of the sphere and of each electrode, charge over potential
};

/// Returns 4 pi eps R (F), the capacitance of an isolated sphere (below D 4.20).
double isolated_sphere_capacitance(double radius, double permittivity);

/// Returns the force (N) toward the electrode ahead at x (m, from the middle). Sphere and electrodes have charges +-C V
/// / 2, which attract and repel each other as point charges at the distances a/2 -+ x, a = g + 4R:
///
///   F = 2 (C V)^2 / (4 pi eps) (a^2 + 4 x^2) / (a^2 - 4 x^2)^2.
///
/// D 4.3 prints the denominator without its square.
double monopole_force(const SphereShuttle& shuttle, double x);

/// Returns the time (s) from electrode to electrode without inertia, gamma dx/dt = F:
///
///   t = 4 C/A (a^3 atan(g / a) - (2/3) g (g + 3R)(g + 6R)),  A = 2 C^3 V^2 / (4 pi eps gamma).
///
/// D 4.4 prints it without the 4.
double crossing_time(const SphereShuttle& shuttle);

/// Returns the mean current (A), D 4.2. Each contact reverses the charge -C V / 2 to C V / 2, so C V passes in every
/// second crossing: C V / 2t.
double mean_current(const SphereShuttle& shuttle);

/// Returns the resistance of the gap (ohm): voltage / mean_current = 2 t / C. D 4.6 prints 1/8 of it (for the factor 4
/// of the crossing time and a charge of C V instead of C V / 2), and fits A. The resistance decreases as voltage^-2 (D
/// 4.7).
double resistance(const SphereShuttle& shuttle);

/// Returns the charge (C) of a sphere that touches a plate in a homogeneous field (V/m): 2/3 pi^3 eps R^2 E (Maxwell's
/// Treatise, art. 175; Lebedev and Skal'skaya, Sov. Phys. Tech. Phys. 7, 268 (1962)).
double sphere_on_plate_charge(double radius, double permittivity, double field);

/// Returns the time (s) from x = `from` to `to` (m) at the overdamped speed force(x) / drag.
double overdamped_time(const std::function<double(double)>& force, double drag, double from, double to);

/// Returns the time (s) from x = `from` to `to` (m) at a constant speed with elastic reflection at both ends, the limit
/// of large inertia. The force's work equals the dissipation by drag, drag v (to - from). The time is never longer than
/// without inertia, because the mean of a force is at least its harmonic mean.
double ballistic_time(const std::function<double(double)>& force, double drag, double from, double to);

}  // namespace lichtenberg::theory
