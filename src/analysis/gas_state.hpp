#pragma once

#include "src/analysis/gas_clusters.hpp"
#include "src/analysis/gas_distributions.hpp"
#include "src/analysis/gas_temperature.hpp"

namespace lichtenberg::analysis {

/// What a gas of grains is like at an instant.
struct GasState {
  GranularTemperature temperature;
  double sonine = 0;  ///< a_2
  ChargeMoments charge;
  ClusterSizes contact;  ///< of clusters of grains in contact
  DensityClusters density;
};

/// `contacts`: the pairs in contact. All by loops over grains, cells and contacts.
GasState gas_state(const Bodies& bodies, std::span<const Pair> contacts);

}  // namespace lichtenberg::analysis
