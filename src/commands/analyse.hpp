#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "src/analysis/power.hpp"
#include "src/analysis/topology.hpp"
#include "src/record/result.hpp"

namespace lichtenberg {

/// What a run with a circuit has recorded of currents and powers, means since the frame before.
struct Recorded {
  std::string name, unit;
  bool by_terminal = false;
  std::vector<double> values;  ///< by terminal, or one
};

/// What `analyse` finds of one frame.
struct FrameAnalysis {
  int frame = 0;
  double time = 0;  ///< s
  analysis::Topology topology;
  analysis::Power power;
  /// W, since the frame before: as recorded, in the scene of a circuit, else by dissipated_power(). Empty for the
  /// first.
  std::optional<double> dissipated;
  std::vector<Recorded> recorded;
};

/// The run that is analysed.
struct AnalysedRun {
  std::string file, title;
  int conductors = 0, frames = 0;
  double radius = 0;                  ///< m, mean
  bool contacts_recorded = false;     ///< else they are those of D 7.1 and of the recorded tree
  std::vector<std::string> warnings;  ///< Summary::warnings
};

/// Everything found as named quantities with units: what the file and the JSON hold. One row a frame; numbers by
/// degree, order or the like are padded with zeros to the longest, and what does not exist at a frame is NaN.
std::vector<Column> columns_of(const AnalysedRun& run, const std::vector<FrameAnalysis>& frames);

/// A line for each frame, and all there is of the last of them.
void print_analysis(const AnalysedRun& run, const std::vector<FrameAnalysis>& frames);

nlohmann::ordered_json analysis_json(const AnalysedRun& run, const std::vector<FrameAnalysis>& frames);

}  // namespace lichtenberg
