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

/// State of a scene of conductors at the end of a run, with the initial values and extremes that its summary needs.
struct Outcome {
  ConductorFrame frame;                             ///< last frame
  std::optional<analysis::ContactNetwork> network;  ///< of that frame
  bool stationary = false;
  double initial_charge = 0;            ///< C, on the conductors at the start
  double initial_energy = 0;            ///< J, analysis::energy_account() at the start, of a scene with a circuit
  std::optional<double> largest_error;  ///< estimate, of the field; empty without field.accuracy
  double largest_overlap = 0;           ///< of all frames (mechanics::largest_overlap)
  Counters counters;
};

/// Returns the error of the charge balance (C): stored + collected + leaked - injected - initial charge. 0 in a neutral
/// scene.
double charge_imbalance(const Outcome& outcome);
/// Returns the error of the energy balance (J) since the start, for a scene with a circuit: stored energy plus heat
/// minus supplied energy, minus the same sum at the start.
double energy_imbalance(const Outcome& outcome);

/// Returns the largest relative overlap of bodies; 0 without overlaps. The overlap of two bodies is relative to the sum
/// of their radii. The overlap of a body with an electrode, or with a side of the domain that is not periodic, is
/// relative to the body's diameter. Fixed bodies count only if they overlap a free body.
double largest_overlap(const Scene& scene, const Bodies& bodies);

/// Makes the summary of a run of conductors: network, charges, energies, counts of field solves, and warnings.
Summary summarize(const Scene& scene, const Outcome& outcome);

/// Returns a warning if the energy balance of a scene with a circuit has too large an error; otherwise an empty string.
/// Errors that steps, grid and the tolerance of field solves explain are allowed.
std::string energy_warning(const Scene& scene, const Outcome& outcome);

}  // namespace lichtenberg::mechanics
