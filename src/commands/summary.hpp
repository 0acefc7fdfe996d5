#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "src/analysis/network.hpp"
#include "src/mechanics/counters.hpp"
#include "src/model/frame.hpp"
#include "src/record/recorder.hpp"

namespace lichtenberg {

/// How far a run came.
struct Outcome {
  Frame frame;                               ///< the last one
  std::optional<analysis::Network> network;  ///< of that frame
  bool over = false;
  bool stationary = false;
  double initial_charge = 0;            ///< C, on the conductors at the start
  std::optional<double> largest_error;  ///< of the field, estimated at checkpoints; empty if no accuracy is asked for
};

/// What the source fed in is held or has drained (C); the rest is an error. Zero in a neutral scene.
double charge_imbalance(const Outcome& outcome);
/// The same as a fraction of the largest charge in that balance.
double relative_charge_imbalance(const Outcome& outcome);

/// Where the time went (s, by activity), on standard output.
void print_seconds(const std::map<std::string, double>& seconds);

/// For the result file: no timings, so that equal runs leave equal numbers.
std::vector<Quantity> quantities(const Outcome& outcome);

/// The same for people, on standard output, with what was done and where the time went (s, by activity).
void print_summary(const std::string& file, const Outcome& outcome, const Counters& counters,
                   const std::map<std::string, double>& seconds);

}  // namespace lichtenberg
