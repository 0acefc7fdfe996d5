#pragma once

#include <array>
#include <complex>
#include <span>
#include <vector>

namespace lichtenberg::theory {

// Onset of clustering in a homogeneous gas of charged grains of constant restitution (G chapter 6): small disturbances
// exp(i k x) of the hydrodynamic equations. Units follow from nu_0 = (16/5) n d^2 sqrt(pi T/m): time t_0 = 1/(2 nu_0),
// speed sqrt(2T/m), length l_0 = t_0 sqrt(2T/m) = .12467/(n d^2). All are instantaneous values.

/// Transport coefficients of a granular gas, dimensionless: cooling rate zeta*, shear viscosity eta*,
/// thermal conductivity kappa* and coefficient mu* of the heat flux by density gradients. Source: G, appendix 3,
/// (2)-(8); Brey, Dufty, Kim and Santos 1998.
struct TransportCoefficients {
  double cooling = 0, viscosity = 0, conduction = 0, density_conduction = 0;
};
/// Computes the transport coefficients for a restitution coefficient. Throws InputError unless 0 < restitution <= 1.
TransportCoefficients transport_coefficients(double restitution);

/// Computes the unit of length l_0, about half a mean free path, in diameters. `density`: grains per cubic diameter.
double hydrodynamic_length(double density);

/// Computes the dimensionless charge number R = 2 pi K n q^2 l_0^2 / T. `coupling`: K. q is the mean charge of a grain,
/// and l_0 = hydrodynamic_length(density). G 6.30 prints t_0 l_0 for l_0^2.
double charge_number(double coupling, double density, double mean_charge, double temperature);

/// Growth rates (1/t_0) of the hydrodynamic modes of wave number k (1/l_0): a mode grows if the real part of its rate
/// is above 0.
struct Modes {
  double wave_number = 0;
  /// Complex growth rates of the three modes that couple density, temperature, velocity along k and potential (G 6.39),
  /// without the eigenvalue 0; continuous in k.
  std::array<std::complex<double>, 3> longitudinal{};
  double shear = 0;  ///< zeta*/4 - eta* k^2, for both velocities across k
};
/// Computes the growth rates (dispersion relation) at these positive wave numbers, in ascending order. At the first
/// wave number the modes are in descending order of their real parts. `charge_number`: R >= 0.
std::vector<Modes> growth_rates(const TransportCoefficients& c, double charge_number, std::span<const double> k);

/// Amplitudes of a small disturbance exp(i k x) of density, temperature and speed; charges move with the grains.
struct Disturbance {
  std::complex<double> density, temperature;
  std::complex<double> speed;  ///< i times velocity along k
};
/// Integrates a disturbance of wave number k > 0 by the linearized hydrodynamic equations (G 6.39). Returns the
/// disturbance at these times (t_0, ascending, >= 0). `charges_last`: charges do not decay with the thermal speed, so
/// that R grows as 1/T.
std::vector<Disturbance> disturbance_evolution(const TransportCoefficients& c, double charge_number, bool charges_last,
                                               double k, const Disturbance& start, std::span<const double> times);

/// Characteristic polynomial lambda^3 + a lambda^2 + b lambda + c, whose roots are the three longitudinal growth rates.
struct Cubic {
  double a = 0, b = 0, c = 0;
};
/// Computes the characteristic polynomial at the wave number k (1/l_0). `charge_number`: R.
Cubic characteristic(const TransportCoefficients& c, double charge_number, double k);

/// Critical wave number, at which the growth rate of a longitudinal mode changes sign.
struct CriticalWave {
  double wave_number = 0;
  bool oscillates = false;  ///< true: a pair of sound modes; false: the heat mode
};
/// Finds the critical wave numbers between `least` and `most` (1/l_0), in ascending order. They are sign changes of the
/// product of the numerical eigenvalues and of the product of their pair sums. `charge_number`: R.
std::vector<CriticalWave> critical_waves(const TransportCoefficients& c, double charge_number, double least = 1e-3,
                                         double most = 1);
/// Finds the critical wave numbers by the Routh-Hurwitz criterion: zeros of c and of a b - c of the characteristic
/// polynomial. An independent check of critical_waves().
std::vector<CriticalWave> routh_hurwitz_waves(const TransportCoefficients& c, double charge_number, double least = 1e-3,
                                              double most = 1);

/// Computes the wave number (1/l_0) below which the shear mode grows, sqrt(zeta*/(4 eta*)), from the cooling rate zeta*
/// and the shear viscosity eta*.
double critical_shear(const TransportCoefficients& c);

}  // namespace lichtenberg::theory
