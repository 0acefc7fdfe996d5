#pragma once

#include <functional>
#include <span>
#include <vector>

#include "src/theory/haff.hpp"

namespace lichtenberg::theory {

// A homogeneous gas of charged grains that charge each other, lose energy and merge (G chapter 5, corrected), in
// reduced units. All aggregates have the same mass m = n_0/n and diameter d = (n_0/n)^(1/D_f), Gaussian velocities of
// variance T/m a component and Gaussian charges of variance <q^2>, independent of each other.
//
// Two at x = (m v^2/4)/T with charges of b = K |q_i q_j| / (d T), s = sign(q_i q_j), meet in the cross-section
// pi d^2 (1 - s b/x): any psi changes, by contacts and in a unit of volume and time, at the rate
//   2 sqrt(pi) n^2 d^2 sqrt(T/m) < int dx (x - s b) exp(-x) int_0^1 du psi >,   v_n^2 = (4T/m) x u.
// They merge if x < b and s < 0, and bounce if x > b. Averages over charges depend on B = K <q^2> / (T d) alone.

/// P_N, P_T, P_Q of merging at beta = 2B >= 0, to 1e-12 of each:
///   P = 2 int_0^inf K_0(2w) {h_N(beta w), h_T(beta w), w h_N(beta w)} dw,
/// h_N(b) and h_T(b) the integrals of (x + b) exp(-x) and of x (x + b) exp(-x) from 0 to b.
struct MergingIntegrals {
  double number = 0, energy = 0, charge = 0;
};
/// Throws InputError unless 0 <= beta < 1e150.
MergingIntegrals merging_integrals(double beta);

/// G(p) = int int exp(-x^2 - y^2) Gamma(p, beta |x y|) dx dy, p > 0 and beta >= 0, to 1e-12 of it.
double contact_integral(double p, double beta);

/// Means over the impacts of a Maxwellian gas (haff.hpp) by T/m, all that the rates of contacts need.
struct ImpactMeans {
  std::function<double(double)> loss;    ///< <(1 - eps(v)^2) x>
  std::function<double(double)> charge;  ///< <dq(v)^2>
};
/// From quadrature, tabulated over T/m from 1e-20 to `hottest`, to 1e-9; below, they are as at 1e-20.
ImpactMeans tabulated_means(const Impacts& impacts, double hottest);

struct Aggregates {
  double density = 0;        ///< n
  double temperature = 0;    ///< T
  double charge_square = 0;  ///< <q^2>
  double mass = 1, diameter = 1;

  double bjerrum(double coupling) const { return coupling * charge_square / (temperature * diameter); }  ///< B
};

/// 2 sqrt(pi T/m) n^2 d^2, the encounters that rates are shares of, a volume and time.
double encounter_rate(const Aggregates& gas);

/// Of a unit of volume and time.
struct KineticRates {
  double mergers = 0;         ///< N_m
  double contact_loss = 0;    ///< L_r, of energy
  double merging_loss = 0;    ///< L_m
  double contact_charge = 0;  ///< S_r, what n <q^2> gains
  double merging_charge = 0;  ///< S_m, what it loses
};

/// As above; `coupling`: K.
KineticRates kinetic_rates(const Aggregates& gas, double coupling, const ImpactMeans& means);

/// The same with the speed that charges give on the way, v_n^2 = (4T/m) (x - s b) u, and with merging of those that
/// cannot part any more, x < (1 - eps^2) (x + b) u with s < 0. To 1e-6.
KineticRates contact_speed_rates(const Aggregates& gas, double coupling, const Impacts& impacts);

struct KineticGas {
  double density = 0;              ///< n_0 of grains
  double temperature = 0;          ///< at the start, when no grain is charged
  double coupling = 0;             ///< K
  double fractal_dimension = 3;    ///< D_f
  Impacts impacts{};               ///< of grains and of aggregates alike, by their speed
  double contact_value = 1;        ///< g, by which all is more frequent
  bool merges = true;              ///< or N_m = L_m = S_m = 0, and aggregates remain grains
  bool speeds_at_contact = false;  ///< `contact_speed_rates`, which `merges` has no say in
};

struct KineticState {
  double density = 0, temperature = 0, charge_square = 0;
  double bjerrum = 0;  ///< B
};

/// The gas at these times (rising, >= 0), to 1e-8 (speeds at contact: 1e-5):
///   dn/dt = -N_m,  d(3nT/2)/dt = -L_r - L_m,  d(n <q^2>)/dt = S_r - S_m,
/// with all rates times g / (1 + omega t_c) if impacts have a duration t_c.
std::vector<KineticState> kinetic_course(const KineticGas& gas, std::span<const double> times);

}  // namespace lichtenberg::theory
