#pragma once

#include "solvers/minimize/minimizer.hpp"

namespace lichtenberg::minimize {

/// Gradient descent x <- x - step * gradient, the gradient flow dx/dt = -gradient by Euler's method. Small steps end in
/// the same minimum as the flow. A step is shortened if it would increase the value, or change a component by more than
/// `largest_move`.
class GradientDescent : public Minimizer {
 public:
  GradientDescent(Objective& objective, std::vector<double> x, double step, double largest_move);
  bool iterate() override;

 private:
  double step_, largest_move_;
  Point next_;
};

}  // namespace lichtenberg::minimize
