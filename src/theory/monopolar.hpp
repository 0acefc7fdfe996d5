#pragma once

namespace lichtenberg::theory {

/// A freely cooling gas of grains with equal charges of one sign: two of them have the energy U = K q^2 / d at contact.
/// The cross-section pi d^2 (1 - U/energy) reduces the collision frequency of a Maxwellian gas by the factor exp(-U/T).
/// The energy loss is reduced by the same factor:
///
///   dT/dt = -2 / (tau sqrt(T_0)) T^(3/2) exp(-U/T).
///
/// Reduced units. Neighbours make U smaller than that of a pair (Scheffler and Wolf 2002).
struct MonopolarGas {
  double initial = 0;  ///< T_0
  double tau = 0;      ///< Haff's time of an uncharged gas (`haff_time`)
  double barrier = 0;  ///< U
};

/// Computes the barrier U_eff = U (1 - 2.40 phi^(1/3) + 1.44 phi^(2/3)) of grains with the volume fraction phi, at
/// least 0. Neighbours take over a part of the energy U of a pair (Scheffler and Wolf 2002). Both constants, and their
/// uncertainty of 0.15, are quoted from memory: they are not yet checked against the paper. The law is for temperatures
/// below U_eff, where charges are strongly correlated.
double effective_barrier(double barrier, double filling);

/// Computes ln h(x) for x > 0, where h(x) = e^x Dawson(sqrt(x)) is the integral of exp(u^2) from 0 to sqrt(x). The
/// relative accuracy of ln h is about 1e-14 where |ln h| > 1, and its error about 1e-14 otherwise.
double log_h(double x);

/// Computes the temperature T of the monopolar gas at this time, from h(U/T) - h(U/T_0) = (t/tau) sqrt(U/T_0), with h
/// of log_h(). For U -> 0 this is Haff's law; at late times T decreases like U / ln t.
double monopolar_temperature(const MonopolarGas& gas, double time);

/// Computes the time at which the monopolar gas has this temperature, 0 < T <= T_0; infinite if it exceeds the range of
/// double.
double monopolar_time(const MonopolarGas& gas, double temperature);

}  // namespace lichtenberg::theory
