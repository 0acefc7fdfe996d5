#pragma once

namespace lichtenberg::theory {

/// A gas of grains with charges of one sign: two have the energy U = K q^2 / d at contact. The collision frequency is
/// lower than for neutral grains by the factor exp(-U/T) (sigma = pi d^2 (1 - U/energy) over a Maxwellian), and so is
/// the loss:
///
///   dT/dt = -2 / (tau sqrt(T_0)) T^(3/2) exp(-U/T).
///
/// Reduced units; neighbours make U smaller than that of a pair (Scheffler and Wolf 2002).
struct MonopolarGas {
  double initial = 0;  ///< T_0
  double tau = 0;      ///< Haff's time of an uncharged gas (`haff_time`)
  double barrier = 0;  ///< U
};

/// Returns ln h(x), h(x) = e^x Dawson(sqrt(x)) = integral of exp(u^2) from 0 to sqrt(x), x > 0. h has a relative
/// accuracy of 1e-14 for any x.
double log_h(double x);

/// Returns T at this time, from h(U/T) - h(U/T_0) = (t/tau) sqrt(U/T_0). For U -> 0 this is Haff's law; for late times
/// T -> U / ln(t/t_c).
double monopolar_temperature(const MonopolarGas& gas, double time);

/// Returns the time at which the gas has this temperature, 0 < T <= T_0; infinite if it exceeds the range of double.
double monopolar_time(const MonopolarGas& gas, double temperature);

}  // namespace lichtenberg::theory
