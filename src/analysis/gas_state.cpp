#include "src/analysis/gas_state.hpp"

namespace lichtenberg::analysis {

GasState gas_state(const Bodies& bodies, std::span<const Pair> contacts) {
  return {.temperature = granular_temperature(bodies),
          .sonine = sonine(bodies),
          .charge = charge_moments(bodies.charge),
          .contact = cluster_sizes(cluster_numbers(bodies.size(), contacts)),
          .density = density_clusters(bodies)};
}

}  // namespace lichtenberg::analysis
