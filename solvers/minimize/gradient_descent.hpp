#pragma once

#include "solvers/minimize/minimizer.hpp"

namespace lichtenberg::minimize {

/// x <- x - step * gradient: the gradient flow dx/dt = -gradient by Euler's method. Small steps end in the minimum that
/// the flow leads to; a step that would go up, or move a component by more than `largest_move`, is shortened.
class GradientDescent : public Minimizer {
 public:
  GradientDescent(Objective& objective, std::vector<double> x, double step, double largest_move);
  bool iterate() override;

 private:
  double step_, largest_move_;
  Point next_;
};

}  // namespace lichtenberg::minimize
