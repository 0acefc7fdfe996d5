#pragma once

#include <optional>
#include <string>

#include "src/model/grain_contact_law.hpp"
#include "src/scene/scene.hpp"
#include "src/theory/haff.hpp"

namespace lichtenberg {

/// Computes the number density of grains in the box, 1/d0^3 (in a plane 1/d0^2).
double grain_density(const Scene& scene);

/// Returns the granular temperature (m0 v0^2) at the end of the equilibration stages: the last one that a stage sets,
/// or that of the initial velocities.
double initial_temperature(const Scene& scene);

/// Returns the end (t0) of the last equilibration stage that conserves energy or sets the temperature; 0 without one.
/// Theory begins there.
double warm_up(const Scene& scene);

/// Computes the restitution coefficient of two grains of diameter and mass 1 at this impact speed (v0).
double restitution(const GrainContactLaw& law, double speed);
/// Computes the contact duration (t0) of two grains of diameter and mass 1 at this impact speed (v0).
double contact_duration(const GrainContactLaw& law, double speed);

/// Parameters of a homogeneous gas of grains for theories, in reduced units.
struct GasParameters {
  std::string source;           ///< description of their origin
  double grains = 0;            ///< number of grains
  double density = 0;           ///< number density
  double temperature = 0;       ///< at the start, after the warm-up
  double warm_up = 0, end = 0;  ///< t0; the end is counted from the end of the warm-up
  GrainContactLaw law;
  double coupling = 0;  ///< K; 0 without forces of charges
  double charge = 0;    ///< rms charge of a grain at the start
  double mean_charge = 0;
  /// Charge that grains transfer in a collision, as a function of the impact energy (theory::impact_charge_square).
  struct Exchange {
    double strength = 0, exponent = 0;  ///< Q and eta, charge transfer once per collision (G 4.3)
  };
  std::optional<Exchange> exchange;

  /// Returns the collision laws of the grains: restitution and charge transfer as functions of the impact speed.
  /// `last`: true adds the mean contact duration as a function of the temperature.
  theory::Impacts impacts(bool last = false) const;
};

/// Returns the parameters of a scene of grains for theories of a homogeneous gas. Throws InputError if these do not
/// apply. The scene must be a gas of moving grains of diameter and mass 1 in space without external forcing. Its grains
/// must transfer charge by the model "impact" once per collision without a capacity, or not at all. The run must be
/// longer than its warm-up.
GasParameters gas_parameters(const Scene& scene);

/// Returns the gas of 50016 charging grains of the source (G chapter 4): stiffness E = 278.6, damping D = 27.7,
/// temperature T = 10, K = 1, and charge transfer with Q = 4.5e-3, eta = .83.
GasParameters source_gas();
/// Returns the gas of equal charges of the source (G 4.1a): restitution .9, K = .1, q = 1, T = 10. The source gives no
/// other values; they are those of source_gas().
GasParameters source_monopolar_gas();

}  // namespace lichtenberg
