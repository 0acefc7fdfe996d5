#pragma once

#include <Eigen/SparseCore>
#include <vector>

#include "solvers/network/network.hpp"

namespace lichtenberg::network {

/// S = sum over links of g (e_a - e_b)(e_a - e_b)^T (S), so that S v are the currents (A) into the nodes at potentials
/// v (V).
inline Eigen::SparseMatrix<double> conductance_matrix(const Network& network) {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(4 * network.links.size());
  for (const Link& link : network.links) {
    if (link.a == link.b) continue;
    entries.emplace_back(link.a, link.a, link.conductance);
    entries.emplace_back(link.b, link.b, link.conductance);
    entries.emplace_back(link.a, link.b, -link.conductance);
    entries.emplace_back(link.b, link.a, -link.conductance);
  }
  Eigen::SparseMatrix<double> matrix(network.nodes, network.nodes);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

}  // namespace lichtenberg::network
