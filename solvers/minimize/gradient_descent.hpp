#pragma once

#include "solvers/minimize/minimizer.hpp"

namespace lichtenberg::minimize {

/// Minimizer by gradient descent: x <- x - step * gradient. This is Euler's method for the gradient flow (steepest
/// descent) dx/dt = -gradient; with small steps x follows the flow.
class GradientDescent : public Minimizer {
 public:
  /// Starts the minimization at x. `step`: factor of the gradient, or time step of the flow. `largest_move`: upper
  /// limit of the change of a component of x in one iteration. A step is halved while it would increase the value by
  /// more than rounding.
  GradientDescent(Objective& objective, std::vector<double> x, double step, double largest_move);
  bool iterate() override;

 private:
  double step_, largest_move_;
  Point next_;
};

}  // namespace lichtenberg::minimize
