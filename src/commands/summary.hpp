#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "src/analysis/network.hpp"
#include "src/mechanics/counters.hpp"
#include "src/model/frame.hpp"
#include "src/record/recorder.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {

/// What the energy of a scene with a circuit is held against.
struct EnergyCheck {
  double initial = 0;  ///< J, analysis::energy_account() at the start
  double allowed = 0;  ///< analysis::allowed_energy_imbalance()
};

/// How far a run came.
struct Outcome {
  Frame frame;                               ///< the last one
  std::optional<analysis::Network> network;  ///< of that frame
  bool over = false;
  bool stationary = false;
  double initial_charge = 0;            ///< C, on the conductors at the start
  EnergyCheck energy_check;             ///< of a scene with a circuit
  std::optional<double> largest_error;  ///< of the field, estimated at checkpoints; empty if no accuracy is asked for
};

/// What the source fed in is held or has drained (C); the rest is an error. Zero in a neutral scene.
double charge_imbalance(const Outcome& outcome);
/// The same as a fraction of the largest charge in that balance.
double relative_charge_imbalance(const Outcome& outcome);

/// What the energy account of a scene with a circuit has gained since the start (J): an error.
double energy_imbalance(const Outcome& outcome);
/// The same as a fraction of what was supplied, or of the heat if that is more.
double relative_energy_imbalance(const Outcome& outcome);
/// A sentence for the user if that is more than is allowed, else nothing.
std::string energy_warning(const Outcome& outcome, const Scene& scene);

/// Where the time went (s, by activity), on standard output.
void print_seconds(const std::map<std::string, double>& seconds);

/// For the result file: no timings, so that equal runs leave equal numbers.
std::vector<Quantity> quantities(const Outcome& outcome);

/// The same for people, on standard output, with what was done and where the time went (s, by activity).
void print_summary(const std::string& file, const Outcome& outcome, const Counters& counters,
                   const std::map<std::string, double>& seconds);

}  // namespace lichtenberg
