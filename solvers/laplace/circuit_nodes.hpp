#pragma once

#include <vector>

#include "solvers/laplace/network.hpp"
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

}  // namespace lichtenberg::laplace
