#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "src/analysis/power.hpp"
#include "src/analysis/topology.hpp"
#include "src/record/result.hpp"

namespace lichtenberg {

/// A quantity of a circuit, such as a current or a power, that a run has recorded as its mean since the previous frame.
struct RecordedQuantity {
  std::string name, unit;
  bool by_terminal = false;
  std::vector<double> values;  ///< one value per terminal, or a single value
};

/// Analysis of one frame of a run of conductors: topology of the contact network, powers, recorded quantities.
struct FrameAnalysis {
  int frame = 0;
  double time = 0;  ///< s
  analysis::Topology topology;
  analysis::Power power;
  /// Mean dissipated power since the previous frame (W): the recorded value in a scene with a circuit, otherwise that
  /// of dissipated_power(). Empty for the first frame.
  std::optional<double> dissipated;
  std::vector<RecordedQuantity> recorded;
};

/// Properties of an analysed run of conductors that do not depend on the frame.
struct AnalysedRun {
  std::string file, title;
  int conductors = 0, frames = 0;
  double radius = 0;                  ///< m, mean
  bool contacts_recorded = false;     ///< otherwise the contacts are those of D 7.1 and of the recorded tree
  std::vector<std::string> warnings;  ///< Summary::warnings
};

/// Converts the analysis of all frames to named columns with units, as stored in the result file and in the JSON. Each
/// frame has one row. Arrays (by degree, order, ...) are padded with zeros to the longest; quantities that a frame
/// lacks are NaN.
std::vector<Column> columns_of(const AnalysedRun& run, const std::vector<FrameAnalysis>& frames);

/// Prints the analysis as a table: one line per frame, then all quantities of the last frame.
void print_analysis(const AnalysedRun& run, const std::vector<FrameAnalysis>& frames);

/// Converts the analysis to JSON: properties of the run, units and frames.
nlohmann::ordered_json analysis_json(const AnalysedRun& run, const std::vector<FrameAnalysis>& frames);

}  // namespace lichtenberg
