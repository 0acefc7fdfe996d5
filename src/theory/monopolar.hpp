#pragma once

namespace lichtenberg::theory {

/// A gas of grains that all repel each other: two have the energy U at contact, K q^2 / d. Fewer collide than of
/// neutral grains, in the ratio exp(-U/T) (sigma = pi d^2 (1 - U/energy) over a Maxwellian), and so the loss is less:
///   dT/dt = -2 / (tau sqrt(T_0)) T^(3/2) exp(-U/T).
/// In reduced units; neighbours make U smaller than that of a pair (Scheffler and Wolf 2002).
struct MonopolarGas {
  double initial = 0;  ///< T_0
  double tau = 0;      ///< Haff's time of the same gas without charges (`haff_time`)
  double barrier = 0;  ///< U
};

/// ln h(x), h(x) = e^x Dawson(sqrt(x)) = integral of exp(u^2) from 0 to sqrt(x), x > 0, to 1e-14 of h for any x.
double log_h(double x);

/// T at this time, from h(U/T) - h(U/T_0) = (t/tau) sqrt(U/T_0). U -> 0 is Haff's law; late, T -> U / ln(t/t_c).
double monopolar_temperature(const MonopolarGas& gas, double time);

/// The time at which that gas has this temperature, 0 < T <= T_0; infinite if no double can hold it.
double monopolar_time(const MonopolarGas& gas, double temperature);

}  // namespace lichtenberg::theory
