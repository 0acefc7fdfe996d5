#pragma once

#include "solvers/minimize/minimizer.hpp"

namespace lichtenberg::minimize {

/// Minimizer by Newton's method with a trust region. In each iteration, preconditioned conjugate gradients (CG)
/// minimize the quadratic model of value, gradient and Hessian (Steihaug 1983). CG ends at its tolerance, at the
/// boundary of the region or after 2000 steps. A direction of negative curvature is followed to the boundary. The
/// region is a ball in the norm of the preconditioner.
class NewtonCg : public Minimizer {
 public:
  /// Starts the minimization at x. `largest_move`: upper limit of the change of a component of x in the first CG step,
  /// which sets the initial radius of the region. `gradient_unit`: scale of gradient components; with g the largest
  /// component, the relative tolerance of CG is sqrt(g / gradient_unit), but at least 0.1 and at most 0.3.
  NewtonCg(SmoothObjective& objective, std::vector<double> x, double largest_move, double gradient_unit);
  bool iterate() override;
  Memory memory() const override { return {{"radius", {radius_}}}; }
  void remember(const Memory& memory) override { radius_ = remembered(memory, "radius", 1).front(); }

  std::int64_t products() const { return products_; }  ///< Number of products with the Hessian matrix so far

 private:
  /// Step (change of x) to an approximate minimum of the quadratic model within the trust region.
  struct Step {
    std::vector<double> move;       ///< Change of x
    double predicted_decrease = 0;  ///< Decrease of the value that the model predicts
    bool to_edge = false;           ///< True if the step ends at the boundary of the trust region
  };
  Step solve_model();
  double gain(const Step& step) const;

  SmoothObjective& smooth_;
  double largest_move_, gradient_unit_, radius_ = 0;
  std::int64_t products_ = 0;
  Point next_;
};

}  // namespace lichtenberg::minimize
