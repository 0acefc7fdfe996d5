#pragma once

#include "src/theory/haff.hpp"

namespace lichtenberg::theory {

/// Parameters of a random gas drag: the drag acceleration `stokes` (v_gas - v) of a gas with a random velocity v_gas at
/// each grain. Each component of v_gas is Gaussian with standard deviation `speed`, and drawn again after each time
/// `hold` (effects::GasDrag).
struct RandomDrag {
  double stokes = 0, speed = 0, hold = 1;
};

/// Computes the time-averaged temperature of a gas of grains that a random gas drag drives and inelastic collisions
/// cool, to 1e-9. `density`: number density; `impacts`: restitution of collisions.
///
/// Within a time `hold`, the correlation C = <v_gas v> of a component grows by stokes (speed^2 - C). It decays at the
/// rate nu at which collisions randomize a grain's velocity. Each collision gives <v.(v' - v)> = -(1 + eps) v_n^2 / 4
/// with the restitution coefficient eps and v_n^2 = 4 T x. With <v^2> = 3 T, nu = omega <(1 + eps) x> / 3 (Enskog's
/// decay of velocities), with the collision frequency omega. The momentum of the partner does not count, because its
/// v_gas is different.
///
/// With lambda = stokes + nu the mean over a time `hold` is
///
///   C = speed^2 stokes / lambda (1 - (1 - exp(-lambda hold)) / (lambda hold)),
///
/// and 2 stokes (C - T) = (omega/3) T <(1 - eps^2) x>. At density 0 this is T = speed^2 (1 - (1 - exp(-S h)) / (S h))
/// with S h = stokes hold. At the times of redrawing the temperature is then speed^2 tanh(S h / 2). Velocities are
/// Maxwellian.
double driven_temperature(double density, const Impacts& impacts, const RandomDrag& drag);

}  // namespace lichtenberg::theory
