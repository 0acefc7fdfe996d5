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

/// State of a scene of conductors at the end of a run.
struct Outcome {
  ConductorFrame frame;                             ///< the last one
  std::optional<analysis::ContactNetwork> network;  ///< of that frame
  bool stationary = false;
  double initial_charge = 0;            ///< C, on the conductors at the start
  double initial_energy = 0;            ///< J, analysis::energy_account() at the start, of a scene with a circuit
  std::optional<double> largest_error;  ///< estimate, of the field; empty without field.accuracy
  double largest_overlap = 0;           ///< of all frames (mechanics::largest_overlap)
  Counters counters;
};

/// Returns the error of the charge balance (C): charge injected minus stored and collected. Zero in a neutral scene.
double charge_imbalance(const Outcome& outcome);
/// Returns the error of the energy balance (J) of a scene with a circuit since the start.
double energy_imbalance(const Outcome& outcome);

/// Returns the largest relative overlap; 0 without overlaps. The overlap of two bodies is relative to the sum of their
/// radii. The overlap of a body with a side of the domain or an electrode is relative to its diameter. Pairs of two
/// fixed bodies do not count.
double largest_overlap(const Scene& scene, const Bodies& bodies);

Summary summarize(const Scene& scene, const Outcome& outcome);

/// Returns a warning if the energy balance of a scene with a circuit has too large an error; otherwise an empty string.
/// Errors due to its steps, its grid and the tolerance of its solves are allowed.
std::string energy_warning(const Scene& scene, const Outcome& outcome);

}  // namespace lichtenberg::mechanics
