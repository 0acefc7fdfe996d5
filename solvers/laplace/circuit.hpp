#pragma once

#include <vector>

#include "solvers/laplace/network_factors.hpp"
#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

/// Floating groups without bodies: nodes of the circuit that carry no field charge. They are eliminated before a field
/// solve, exactly and without loss of digits; couplings between their neighbours replace them.
class CircuitNodes {
 public:
  explicit CircuitNodes(const LaplaceProblem& problem);

  bool any() const { return any_; }
  /// Problem without these nodes. Group numbers stay the same; the eliminated groups, on which nothing depends any
  /// more, are fixed.
  const LaplaceProblem& reduced() const { return reduced_; }
  /// Sets the nodes' potentials (V) [groups] from those of all other groups.
  void set_potentials(std::vector<double>& potential) const;

 private:
  bool any_ = false;
  LaplaceProblem reduced_;
  std::vector<char> is_kept_;
  std::vector<double> flow_;  // Inflow of each node, after the elimination of earlier nodes
  NetworkFactors factors_;
};

/// Returns the charge (C per metre of depth) through each coupling from a to b, such that every floating group's charge
/// balance holds to rounding. If a coupling is so strong that its potential difference is dominated by rounding, its
/// charge follows from the body charges, which `solution` has to all digits.
std::vector<double> coupling_charges(const LaplaceProblem& problem, const LaplaceSolution& solution);

}  // namespace lichtenberg::laplace
