#pragma once

namespace lichtenberg::mechanics {

/// Returns the displacement (m) of a body by a force error that grows linearly from 0 to `error` (N) in `dt` (s), with
/// m dv/dt = F - drag v, `mass` in kg and `drag` in kg/s (0: none):
///   error dt / drag * psi(dt drag / m),   psi(z) = 1/2 - 1/z + (1 - exp(-z)) / z^2,
/// which is error dt / (2 drag) if drag dominates (z >> 1) and error dt^2 / (6 m) if inertia does (z << 1).
double displacement(double error, double dt, double mass, double drag);

/// Returns a lower bound of the time (s) in which a force error that grows at `rate` (N/s) displaces a body by
/// `tolerance` (m). This is the larger of the times of both limits; infinite if the rate is 0.
double time_to_displace(double tolerance, double rate, double mass, double drag);

/// Returns the time (s) in which a body that starts at rest without drag is displaced by `tolerance` (m), if its force
/// error grows with its path as growth t^2 / (2 m). The displacement is growth t^4 / (24 m^2), with `growth` in N^2/m:
/// force times its slope in space.
double time_to_displace_from_rest(double tolerance, double growth, double mass);

/// Returns the time (s) in which a body moves by `distance` (m) with this speed (m/s) and acceleration (m/s^2) in the
/// same direction: v t + a t^2 / 2 = distance.
double time_to_move(double distance, double speed, double acceleration);

/// Returns the step (s) for an error of one tolerance, with a margin: 0.9 dt error^(-1/order), where `error` is that of
/// a step dt, in tolerances, and grows as dt^order. The result is at most 2 dt and at least dt / 5.
double next_step(double dt, double error, int order);

}  // namespace lichtenberg::mechanics
