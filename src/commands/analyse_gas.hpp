#pragma once

#include <optional>
#include <string>
#include <vector>

#include "src/analysis/gas_state.hpp"
#include "src/record/result.hpp"

namespace lichtenberg {

/// Clusters as bodies of their own.
struct ClusterState {
  analysis::ClusterSizes sizes;
  std::vector<int> number;   ///< of clusters by size, from 0 on
  double temperature = 0;    ///< variance of a component of their velocity times mass, over all of them
  double square_charge = 0;  ///< <q^2>
};

/// What `analyse` finds of a frame of a gas of grains.
struct GasFrame {
  int frame = 0;
  double time = 0;  ///< t0
  analysis::GasState gas;
  std::int64_t contacts = 0;
  double total_charge = 0;
  double correlation = 0;  ///< of q^2 and v^2
  analysis::Histogram speeds, charges;
  ClusterState contact;               ///< of clusters of grains in contact
  std::optional<ClusterState> bound;  ///< of those of bound pairs; empty without forces between charges
};

struct AnalysedGas {
  std::string file, title;
  int grains = 0, frames = 0;
};

/// Goes through the frames of a gas.
class GasAnalyser {
 public:
  GasAnalyser(const Result& result, Scene scene);

  AnalysedGas run() const;
  std::vector<GasFrame> all() const;
  GasFrame one(int index) const;

 private:
  Bodies bodies(int index) const;

  const Result& result_;
  Scene scene_;
  Bodies at_start_;
};

// As of conductors (analyse.hpp).
std::vector<Column> columns_of(const AnalysedGas& run, const std::vector<GasFrame>& frames);
void print_analysis(const AnalysedGas& run, const std::vector<GasFrame>& frames);
void print_analysis_json(const AnalysedGas& run, const std::vector<GasFrame>& frames);

}  // namespace lichtenberg
