#pragma once

#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "src/analysis/gas_shapes.hpp"
#include "src/analysis/gas_state.hpp"
#include "src/analysis/gas_structure.hpp"
#include "src/commands/theory_tables.hpp"
#include "src/record/result.hpp"

namespace lichtenberg {

/// Names of the recorded energies of a run of grains.
constexpr std::array energy_names = {"kinetic_energy",    "contact_energy",   "potential_energy",
                                     "dissipated_energy", "exchanged_energy", "driven_energy"};

/// Statistics of the clusters of grains in one frame, each treated as a single body. Reduced units.
struct ClusterState {
  analysis::ClusterSizes sizes;
  std::vector<int> number;       ///< number of clusters of each size, from 0 on
  double temperature = 0;        ///< mass times variance of a velocity component, over all clusters
  double local_temperature = 0;  ///< temperature relative to the local flow in cells
  double square_charge = 0;      ///< <q^2>
  /// Bjerrum parameter B = K <q^2> / (T d) with T relative to the flow and d = (grains a cluster)^(1/3); NaN without K
  double bjerrum = 0;
  std::vector<analysis::ClusterShape> shapes;         ///< clusters of at least six grains
  std::vector<double> charge_dipole, induced_dipole;  ///< of aggregates, by number of grains, from 0 on
  int percolating = 0;                                ///< clusters that span the periodic box
  std::optional<analysis::ClusterDimension> dimension;
  std::optional<analysis::SizeExponent> exponent;  ///< of aggregates
};

/// Analysis of one frame of a gas of grains: statistics, clusters and structure. Reduced units.
struct GasFrame {
  int frame = 0;
  double time = 0;  ///< t0
  analysis::GasState gas;
  std::int64_t contacts = 0;
  std::vector<double> energies;  ///< as `energy_names`, from the run's energy record; NaN if it has none
  double total_charge = 0;
  double correlation = 0;  ///< between q^2 and v^2
  analysis::Histogram speeds, charges;
  ClusterState contact;               ///< clusters of grains in contact
  std::optional<ClusterState> bound;  ///< clusters of bound pairs; empty without forces between charges
  std::optional<analysis::SizeExponent> density_exponent;  ///< of the sizes N_s of dense cells
  analysis::MachNumber mach;
  analysis::StructureFactors structure;
  double displacement = 0;  ///< mean square displacement since the first frame, d0^2
  double persistence = 0;   ///< fraction of the previous frame's contacts that still exist; NaN in the first
  std::vector<double> charge_by_speed;
  double aggregate_slope = NAN, density_slope = NAN;  ///< local exponents of growth (G 4.11)
};

/// Properties of an analysed run of grains that do not depend on the frame.
struct AnalysedGas {
  std::string file, title;
  int grains = 0, frames = 0;
  double warm_up = 0;                 ///< t0
  std::vector<std::string> warnings;  ///< Summary::warnings
  bool charged = false, polarized = false;
  bool coulomb = false;                              ///< forces between charges
  std::map<std::string, std::vector<double>> notes;  ///< time series that the run recorded, also between frames
};

/// Computes the analysis of the frames of a gas of grains from a result file.
class GasAnalyser {
 public:
  /// Prepares the analysis of a result and its scene. `result` must outlive this object. Throws InputError if the two
  /// have different numbers of grains.
  GasAnalyser(const Result& result, Scene scene);

  /// Returns the properties of the run that all frames share, such as title, number of grains and warnings.
  AnalysedGas run() const;
  /// Analyses all frames, including the local exponents of growth.
  std::vector<GasFrame> all() const;
  /// Analyses the frame of this index, from 0. The exponents of growth, which need neighbouring frames, are left out.
  GasFrame one(int index) const;

 private:
  Bodies bodies(int index) const;
  std::vector<double> energies_at(double time) const;
  std::vector<Pair> contacts(int index) const;
  ClusterState state_of(const Bodies& bodies, std::span<const Pair> pairs, std::span<const double> dipole) const;

  const Result& result_;
  Scene scene_;
  Bodies at_start_, first_;  ///< bodies of the scene; bodies of the first frame
  std::optional<GasTimeSeries> time_series_;
};

/// Converts the analysis of a gas to named columns with units, one row per frame.
std::vector<Column> columns_of(const AnalysedGas& run, const std::vector<GasFrame>& frames);
/// Prints the analysis of a gas: one line per frame, then quantities of the last frame and the growth of clusters.
void print_analysis(const AnalysedGas& run, const std::vector<GasFrame>& frames);
/// Converts the analysis of a gas to JSON.
nlohmann::ordered_json analysis_json(const AnalysedGas& run, const std::vector<GasFrame>& frames);

}  // namespace lichtenberg
