#pragma once

namespace lichtenberg::mechanics {

/// How far a force error that grows linearly from 0 to `error` (N) during `dt` (s) displaces a body (m) of `mass` (kg)
/// and drag coefficient `drag` (kg/s; 0: none), with m dv/dt = F - drag v:
///   error dt / drag * psi(dt drag / m),   psi(z) = 1/2 - 1/z + (1 - exp(-z)) / z^2,
/// which is error dt / (2 drag) where drag rules (z >> 1) and error dt^2 / (6 m) where inertia does (z << 1).
double displacement(double error, double dt, double mass, double drag);

/// The time (s) in which a force error that grows at `rate` (N/s) displaces a body by `tolerance` (m), from below: the
/// larger of the two limits' times; infinite if the rate is 0.
double time_to_displace(double tolerance, double rate, double mass, double drag);

/// The time (s) in which a body at rest without drag is displaced by `tolerance` (m) if its force error grows with the
/// way it has fallen since, as growth t^2 / 2 m: displaced by growth t^4 / 24 m^2 (`growth`: N^2/m, force times its
/// slope in space).
double time_to_displace_from_rest(double tolerance, double growth, double mass);

/// The time (s) in which a body of that speed (m/s) and acceleration (m/s2, along the speed at worst) moves by
/// `distance` (m): v t + a t^2 / 2 = distance.
double time_to_move(double distance, double speed, double acceleration);

/// Step that should give an error of one tolerance, with a margin: 0.9 dt error^(-1/order), where `error` is that of
/// a step dt in tolerances and grows as dt^order. Changes by at most a factor 2 up and 5 down.
double next_step(double dt, double error, int order);

}  // namespace lichtenberg::mechanics
