#pragma once

#include "solvers/geometry/host_device.hpp"

namespace lichtenberg::theory {

/// Evaluates at x the polynomial through `value` at the Chebyshev nodes of the second kind `node`, which include both
/// ends. It uses the barycentric formula with the weights of these nodes (Berrut and Trefethen 2004, eq. 5.4).
LICHTENBERG_HOST_DEVICE inline double between_nodes(const double* node, const double* value, int nodes, double x) {
  double sum = 0, weights = 0;
  for (int n = 0; n < nodes; ++n) {
    if (x == node[n]) return value[n];
    const double weight = (n % 2 ? -1.0 : 1.0) * (n == 0 || n == nodes - 1 ? 0.5 : 1.0) / (x - node[n]);
    weights += weight;
    sum += weight * value[n];
  }
  return sum / weights;
}

}  // namespace lichtenberg::theory
