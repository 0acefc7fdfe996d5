#pragma once

namespace lichtenberg::mechanics {

/// Returns the displacement (m) of a body by a force error F that grows linearly from 0 to `error` (N) in `dt` (s). The
/// velocity error v obeys m dv/dt = F - drag v, with `mass` in kg and `drag` in kg/s (0: none). The result is
///   error dt / drag * psi(dt drag / m),   psi(z) = 1/2 - 1/z + (1 - exp(-z)) / z^2.
/// Its limits are error dt / (2 drag) if drag dominates (z >> 1) and error dt^2 / (6 m) if inertia dominates (z << 1).
double displacement(double error, double dt, double mass, double drag);

/// Returns a lower bound of the time (s) in which a force error that grows at `rate` (N/s) displaces a body by
/// `tolerance` (m). The bound is the larger of the times for drag alone and for inertia alone; infinite if the rate is
/// 0. `mass` in kg, `drag` in kg/s.
double time_to_displace(double tolerance, double rate, double mass, double drag);

/// Returns the time (s) in which a force error displaces a body that starts at rest without drag by `tolerance` (m).
/// The error grows with the path of the body, as growth t^2 / (2 m), so that the displacement is growth t^4 / (24 m^2).
/// The time is infinite if `growth` is 0. `growth` (N^2/m): force on the body times the slope of the force in space.
/// `mass` in kg.
double time_to_displace_from_rest(double tolerance, double growth, double mass);

/// Returns the time (s) in which a body moves by `distance` (m) with this speed (m/s) and acceleration (m/s^2) in the
/// same direction: v t + a t^2 / 2 = distance.
double time_to_move(double distance, double speed, double acceleration);

/// Returns the length (s) of the next step, for an error of one tolerance with a margin: 0.9 dt error^(-1/order).
/// `error` is that of a step `dt` (s), in tolerances, and grows as dt^order. The result is at most 2 dt and at least dt
/// / 5.
double next_step(double dt, double error, int order);

}  // namespace lichtenberg::mechanics
