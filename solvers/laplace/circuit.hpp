#pragma once

#include <vector>

#include "solvers/laplace/network_factors.hpp"
#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

/// Circuit nodes of a problem: floating groups without bodies. They have no charge in the field; couplings (lumped
/// capacitances or resistors) join them to other groups. The nodes are eliminated before a field solve, exactly and
/// without loss of digits (star-mesh transformation). Couplings between the neighbouring groups replace them.
class CircuitNodes {
 public:
  /// Eliminates the circuit nodes of a problem.
  explicit CircuitNodes(const LaplaceProblem& problem);

  /// Returns true if the problem has circuit nodes.
  bool any() const { return any_; }
  /// Returns the problem without circuit nodes; only valid if any(). Group numbers stay the same. The eliminated groups
  /// are marked as fixed, and nothing depends on their potentials.
  const LaplaceProblem& reduced() const { return reduced_; }
  /// Computes the potentials (V) of the circuit nodes from those of all other groups, and stores them in `potential`
  /// [groups]. Only valid if any().
  void set_potentials(std::vector<double>& potential) const;

 private:
  bool any_ = false;
  LaplaceProblem reduced_;
  std::vector<char> is_kept_;
  std::vector<double> flow_;  // Charge into each node, after the elimination of earlier nodes
  NetworkFactors factors_;
};

/// Computes the charge (C per metre of depth) that flows through each coupling of the problem from its group a to its
/// group b. The charge balance of every floating group then holds to rounding. If a coupling is so strong that its
/// potential difference is dominated by rounding, its charge follows from the body charges of `solution`.
std::vector<double> coupling_charges(const LaplaceProblem& problem, const LaplaceSolution& solution);

}  // namespace lichtenberg::laplace
