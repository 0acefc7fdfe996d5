#pragma once

#include <functional>
#include <span>
#include <vector>

#include "src/theory/haff.hpp"

namespace lichtenberg::theory {

// Kinetic theory of a homogeneous gas of grains that charge each other, lose energy and coalesce (G chapter 5,
// corrected), in reduced units. All aggregates have the same mass m = n_0/n and diameter d = (n_0/n)^(1/D_f).
// Velocities are Gaussian with variance T/m of a component. Charges are independent of them and Gaussian with variance
// <q^2>.
//
// A pair has the relative speed v, in units x = (m v^2/4)/T, and charges with b = K |q_i q_j| / (d T),
// s = sign(q_i q_j). K is Coulomb's constant. It collides in the cross-section pi d^2 (1 - s b/x). If each contact
// changes a quantity by psi, its rate of change in a unit of volume is
//
//   2 sqrt(pi) n^2 d^2 sqrt(T/m) < int dx (x - s b) exp(-x) int_0^1 du psi >.
//
// The mean is over charges, and the normal speed of impact is v_n^2 = (4T/m) x u.
//
// A pair coalesces if x < b and s < 0, and bounces if x > b. Averages over charges depend only on B = K <q^2> / (T d).

/// Integrals P_N, P_T, P_Q of the rates of coalescence (number, energy, charge) at beta = 2B >= 0, with the Bjerrum
/// parameter B = K <q^2> / (T d). Each has a relative accuracy of 1e-12:
///
///   P = 2 int_0^inf K_0(2w) {h_N(beta w), h_T(beta w), w h_N(beta w)} dw.
///
/// K_0 is the modified Bessel function. h_N(b) and h_T(b) are the integrals of (x + b) exp(-x) and of x (x + b) exp(-x)
/// from 0 to b.
struct MergingIntegrals {
  double number = 0, energy = 0, charge = 0;
};
/// Computes the integrals of coalescence P_N, P_T, P_Q. Throws InputError unless 0 <= beta < 1e150.
MergingIntegrals merging_integrals(double beta);

/// Computes the integral of contacts G(p) = int int exp(-x^2 - y^2) Gamma(p, beta |x y|) dx dy to a relative accuracy
/// of 1e-12. Gamma is the upper incomplete gamma function. Throws InputError unless p > 0 and beta >= 0.
double contact_integral(double p, double beta);

/// Means over the impacts of a Maxwellian gas (impact_mean) as functions of T/m, which determine the rates of contacts.
struct ImpactMeans {
  std::function<double(double)> loss;    ///< <(1 - eps(v)^2) x>
  std::function<double(double)> charge;  ///< <dq(v)^2>
};
/// Tabulates the means over impacts by quadrature, over T/m from 1e-20 to `hottest`, to 1e-9. Outside this range they
/// are constant.
ImpactMeans tabulated_means(const Impacts& impacts, double hottest);

/// State of a gas of equal aggregates of grains, in reduced units: number density, temperature, mean square charge, and
/// mass and diameter of an aggregate.
struct Aggregates {
  double density = 0;        ///< n
  double temperature = 0;    ///< T
  double charge_square = 0;  ///< <q^2>
  double mass = 1, diameter = 1;

  /// Returns the Bjerrum parameter B = K <q^2> / (T d): the Bjerrum length K <q^2> / T over the diameter d.
  /// `coupling`: K.
  double bjerrum(double coupling) const { return coupling * charge_square / (temperature * diameter); }  ///< B
};

/// Computes the encounter rate of a gas of aggregates, 2 sqrt(pi T/m) n^2 d^2, per volume and time. It is the common
/// factor of all rates of the kinetic theory.
double encounter_rate(const Aggregates& gas);

/// Rates of coalescence, energy loss and charging of a gas of aggregates, per unit of volume and time.
struct KineticRates {
  double mergers = 0;         ///< N_m, coalescence rate
  double contact_loss = 0;    ///< L_r, energy loss by bouncing contacts
  double merging_loss = 0;    ///< L_m, energy loss by coalescence
  double contact_charge = 0;  ///< S_r, gain of n <q^2> by contacts
  double merging_charge = 0;  ///< S_m, loss of n <q^2> by coalescence
};

/// Computes the rates of coalescence, energy loss and charging of a gas of aggregates by kinetic theory (G chapter 5,
/// corrected). `coupling`: K, Coulomb's constant. `means`: means over impacts.
KineticRates kinetic_rates(const Aggregates& gas, double coupling, const ImpactMeans& means);

/// Computes KineticRates with an impact speed that includes the acceleration by charges, v_n^2 = (4T/m) (x - s b) u. In
/// units of T, x = m v^2/(4T) is the relative energy and b = K |q_i q_j|/(d T) the charge energy. s is the sign of q_i
/// q_j. The impact parameter gives u, uniform in [0, 1]. Pairs that cannot separate after the contact coalesce: x < (1
/// - eps^2) (x + b) u with s < 0. Accurate to 1e-6. `coupling`: K.
KineticRates contact_speed_rates(const Aggregates& gas, double coupling, const Impacts& impacts);

/// Parameters of a charging and coalescing gas for kinetic_evolution(), in reduced units.
struct KineticGas {
  double density = 0;            ///< n_0, density of grains
  double temperature = 0;        ///< initial temperature, with uncharged grains
  double coupling = 0;           ///< K
  double fractal_dimension = 3;  ///< D_f
  Impacts impacts{};             ///< for grains and aggregates, as functions of their speed
  double contact_value = 1;      ///< g, factor of all rates
  /// True: aggregates coalesce. False: the coalescence rates N_m, L_m and S_m are 0, and aggregates remain grains.
  bool merges = true;
  /// True: rates by contact_speed_rates(), which ignores `merges`; false: by kinetic_rates().
  bool speeds_at_contact = false;
};

/// State of a charging and coalescing gas at one time.
struct KineticState {
  double density = 0, temperature = 0, charge_square = 0;
  double bjerrum = 0;  ///< B
};

/// Integrates density n of aggregates, temperature T and mean square charge <q^2> of a charging and coalescing gas.
/// Returns them at these times (ascending, >= 0), to 1e-8 (with speeds at contact 1e-5):
///
///   dn/dt = -N_m,  d(3nT/2)/dt = -L_r - L_m,  d(n <q^2>)/dt = S_r - S_m.
///
/// N_m, L_r, L_m, S_r and S_m are those of KineticRates, multiplied by g (KineticGas::contact_value). If impacts have a
/// duration t_c, they are also divided by 1 + omega t_c, with the collision frequency omega. Throws Failure if the gas
/// charges too fast to be integrated.
std::vector<KineticState> kinetic_evolution(const KineticGas& gas, std::span<const double> times);

}  // namespace lichtenberg::theory
