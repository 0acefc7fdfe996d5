#pragma once

#include <vector>

#include "solvers/laplace/network_factors.hpp"
#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

/// Floating groups without bodies, nodes of the circuit that the field does not reach. They are eliminated before a
/// field is solved for, exactly and at no loss of digits: couplings between their neighbours take their place.
class CircuitNodes {
 public:
  explicit CircuitNodes(const LaplaceProblem& problem);

  bool any() const { return any_; }
  /// The problem without them: groups keep their numbers, and the nodes', of which nothing depends any more, are fixed.
  const LaplaceProblem& reduced() const { return reduced_; }
  /// Sets the nodes' potentials [groups] from all others'.
  void set_potentials(std::vector<double>& potential) const;

 private:
  bool any_ = false;
  LaplaceProblem reduced_;
  std::vector<char> is_kept_;
  std::vector<double> flow_;  // into each node, with what nodes before it have left
  NetworkFactors factors_;
};

/// Charge (C per metre of depth) that has flowed from a to b through each coupling, such that every floating group's
/// balance holds to rounding. Where a coupling is so strong that its difference of potential is rounding, what it
/// carries follows from the charges, of which `solution` has all digits.
std::vector<double> coupling_charges(const LaplaceProblem& problem, const LaplaceSolution& solution);

}  // namespace lichtenberg::laplace
