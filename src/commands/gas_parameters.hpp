#pragma once

#include <optional>
#include <string>

#include "src/model/grain_contact_law.hpp"
#include "src/scene/scene.hpp"
#include "src/theory/haff.hpp"

namespace lichtenberg {

/// Grains a volume (or area) of the box, 1/d0^3.
double grain_density(const Scene& scene);

/// What the grains' velocities are the temperature of, m0 v0^2, at the start of what is not a stage.
double initial_temperature(const Scene& scene);

/// t0, to the end of the last stage in which nothing is lost or that sets the temperature: then theory begins.
double warm_up(const Scene& scene);

/// Of two grains of diameter and mass 1 that meet at this speed.
double restitution(const GrainContactLaw& law, double speed);
/// t0, of the force between them.
double contact_duration(const GrainContactLaw& law, double speed);

/// What theories of a homogeneous gas need to know, in units of a scene's scales.
struct GasParameters {
  std::string source;           ///< where it is from, in words
  double grains = 0;            ///< how many
  double density = 0;           ///< of them
  double temperature = 0;       ///< at the start, after the warm-up
  double warm_up = 0, end = 0;  ///< t0; the end is counted from the warm-up's
  GrainContactLaw law;
  double coupling = 0;  ///< K; 0 without forces of charges
  double charge = 0;    ///< of a grain at the start, rms
  double mean_charge = 0;
  struct Exchange {
    double strength = 0, exponent = 0;  ///< Q and eta, once a collision (G 4.3)
  };
  std::optional<Exchange> exchange;

  /// Of grains by their speed; `last`: with the time that contacts take.
  theory::Impacts impacts(bool last = false) const;
};

/// Throws InputError if theories of this kind do not hold for the scene: it is no gas of grains of diameter and mass 1
/// in space, nothing moves, something drives it, or charges move by another model than once a collision.
GasParameters gas_parameters(const Scene& scene);

/// The source's gas of 50016 grains (G chapter 4): E = 278.6, D = 27.7, T = 10, K = 1, Q = 4.5e-3.
GasParameters source_gas();
/// Its gas of equal charges (G 4.1a), of which it states less: restitution .9, K = .1, q = 1, T = 10.
GasParameters source_monopolar_gas();

}  // namespace lichtenberg
