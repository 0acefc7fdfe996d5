#pragma once

#include <functional>

namespace lichtenberg::theory {

/// Model of the charge shuttle in space: one sphere that transports charge back and forth between two electrodes at
/// +voltage/2 and -voltage/2 (Stephenson 2018, D 4.2). The electrodes act like spheres of the same radius R. If the
/// sphere touches an electrode, the distance of their centres is 2 R.
struct SphereShuttle {
  double radius = 0;        ///< Radius R (m)
  double gap = 0;           ///< Displacement of the sphere from electrode to electrode (m), g in D
  double voltage = 0;       ///< Potential difference of the electrodes (V)
  double permittivity = 0;  ///< Permittivity (F/m)
  double drag = 0;          ///< Drag force over speed (kg/s), gamma in D
  double capacitance = 0;   ///< Capacitance (F) of the sphere and of each electrode: charge over potential
};

/// Computes the capacitance of an isolated sphere (F), 4 pi eps R (below D 4.20).
double isolated_sphere_capacitance(double radius, double permittivity);

/// Computes the force (N) on the shuttle toward the electrode ahead, at x (m, from the middle). Sphere and electrodes
/// have charges +-C V / 2, which attract and repel each other as point charges at the distances a/2 -+ x, a = g + 4R:
///
///   F = 2 (C V)^2 / (4 pi eps) (a^2 + 4 x^2) / (a^2 - 4 x^2)^2.
///
/// D 4.3 prints the denominator without its square.
double monopole_force(const SphereShuttle& shuttle, double x);

/// Computes the time (s) of the shuttle from electrode to electrode without inertia, gamma dx/dt = F, with the force of
/// monopole_force():
///
///   t = 4 C/A (a^3 atan(g / a) - (2/3) g (g + 3R)(g + 6R)),  A = 2 C^3 V^2 / (4 pi eps gamma).
///
/// D 4.4 prints it without the 4.
double crossing_time(const SphereShuttle& shuttle);

/// Computes the mean current of the shuttle (A), D 4.2: C V / 2t with the crossing time t. Each contact reverses the
/// charge -C V / 2 to C V / 2, so C V passes in every second crossing.
double mean_current(const SphereShuttle& shuttle);

/// Computes the resistance of the gap (ohm): voltage / mean_current = 2 t / C with the crossing time t. D 4.6 prints
/// 1/8 of it (because of the factor 4 of the crossing time and a charge of C V in place of C V / 2), and fits A. The
/// resistance decreases as voltage^-2 (D 4.7).
double resistance(const SphereShuttle& shuttle);

/// Computes the charge (C) of a conducting sphere of radius R that touches a plate in a homogeneous field E (V/m): 2/3
/// pi^3 eps R^2 E (Maxwell's Treatise, art. 175; Lebedev and Skal'skaya, Sov. Phys. Tech. Phys. 7, 268 (1962)).
double sphere_on_plate_charge(double radius, double permittivity, double field);

/// Computes the travel time (s) from x = `from` to `to` (m) without inertia, at the speed force(x) / drag. `force` in
/// N, `drag` in kg/s.
double overdamped_time(const std::function<double(double)>& force, double drag, double from, double to);

/// Computes the travel time (s) from x = `from` to `to` (m) in the limit of large inertia: at a constant speed v, with
/// elastic reflection at both ends. The work of the force equals the dissipation by drag, drag v (to - from). The time
/// is never longer than without inertia, because the mean of a force is at least its harmonic mean.
double ballistic_time(const std::function<double(double)>& force, double drag, double from, double to);

}  // namespace lichtenberg::theory
