#pragma once

#include "src/analysis/gas_clusters.hpp"
#include "src/analysis/gas_distributions.hpp"
#include "src/analysis/gas_temperature.hpp"

namespace lichtenberg::analysis {

/// Statistics of a gas of grains at an instant: temperature, velocity and charge distributions, clusters.
struct GasState {
  GranularTemperature temperature;
  double sonine = 0;  ///< a_2
  ChargeMoments charge;
  ClusterSizes contact;  ///< clusters of grains in contact
  DensityClusters density;
};

/// Computes the temperature, the velocity and charge statistics and the clusters of a gas of grains. `contacts`: pairs
/// in contact.
GasState gas_state(const Bodies& bodies, std::span<const Pair> contacts);

}  // namespace lichtenberg::analysis
