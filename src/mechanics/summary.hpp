#pragma once

#include <optional>
#include <string>

#include "src/analysis/network.hpp"
#include "src/effects/conductor_frame.hpp"
#include "src/mechanics/counters.hpp"
#include "src/model/bodies.hpp"
#include "src/model/motion.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::mechanics {

/// How far a scene of conductors came.
struct Outcome {
  ConductorFrame frame;                             ///< the last one
  std::optional<analysis::ContactNetwork> network;  ///< of that frame
  bool stationary = false;
  double initial_charge = 0;            ///< C, on the conductors at the start
  double initial_energy = 0;            ///< J, analysis::energy_account() at the start, of a scene with a circuit
  std::optional<double> largest_error;  ///< of the field, as estimated; empty if no accuracy is asked for
  double largest_overlap = 0;           ///< of all frames (mechanics::largest_overlap)
  Counters counters;
};

/// What the source fed in is held or has drained (C); the rest is an error. Zero in a neutral scene.
double charge_imbalance(const Outcome& outcome);
/// What the energy account of a scene with a circuit has gained since the start (J): an error.
double energy_imbalance(const Outcome& outcome);

/// The deepest overlap of two bodies over the sum of their radii, or of a body with a side of the domain or an
/// electrode over its diameter; 0 if none overlap. Pairs that are both held do not count.
double largest_overlap(const Scene& scene, const Bodies& bodies);

Summary summarize(const Scene& scene, const Outcome& outcome);

/// A warning if the energy of a scene with a circuit is off by more than its steps, its grid and the tolerance of its
/// solves account for, else nothing.
std::string energy_warning(const Scene& scene, const Outcome& outcome);

}  // namespace lichtenberg::mechanics
