#pragma once

#include <optional>
#include <string>

#include "src/model/grain_contact_law.hpp"
#include "src/scene/scene.hpp"
#include "src/theory/haff.hpp"

namespace lichtenberg {

/// Returns the number density of grains in the box, 1/d0^3 (in a plane 1/d0^2).
double grain_density(const Scene& scene);

/// Returns the temperature (m0 v0^2) of the grains' velocities at the end of the equilibration stages.
double initial_temperature(const Scene& scene);

/// Returns the end (t0) of the last stage that conserves energy or sets the temperature. Theory begins there.
double warm_up(const Scene& scene);

/// Returns the restitution coefficient of two grains of diameter and mass 1 at this impact speed.
double restitution(const GrainContactLaw& law, double speed);
/// Returns the contact duration (t0) of these grains.
double contact_duration(const GrainContactLaw& law, double speed);

/// Parameters of theories of a homogeneous gas, in the scene's units.
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
  struct Exchange {
    double strength = 0, exponent = 0;  ///< Q and eta, charge transfer once per collision (G 4.3)
  };
  std::optional<Exchange> exchange;

  /// Returns impact functions of the impact speed. `last`: with the finite duration of contacts.
  theory::Impacts impacts(bool last = false) const;
};

/// Returns the parameters of a scene. Throws InputError if theories of a homogeneous gas do not apply. The scene must
/// be a gas of grains of diameter and mass 1 in space that move without external forcing. It must transfer charge once
/// per collision, or not at all.
GasParameters gas_parameters(const Scene& scene);

/// Returns the source's gas of 50016 grains (G chapter 4): E = 278.6, D = 27.7, T = 10, K = 1, Q = 4.5e-3.
GasParameters source_gas();
/// Returns the source's gas of equal charges (G 4.1a). The source gives only: restitution .9, K = .1, q = 1, T = 10.
GasParameters source_monopolar_gas();

}  // namespace lichtenberg
