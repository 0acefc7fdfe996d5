#pragma once

#include "solvers/minimize/minimizer.hpp"

namespace lichtenberg::minimize {

/// Newton's method with a trust region. Preconditioned conjugate gradients minimize the quadratic model until it is
/// accurate enough, reaches the region's boundary or finds negative curvature, along which it goes to the boundary
/// (Steihaug 1983). The region is a ball in the preconditioner's norm.
class NewtonCg : public Minimizer {
 public:
  /// Starts at x. `largest_move`: change of a component in the first iteration; `gradient_unit`: scale of a large
  /// gradient.
  NewtonCg(SmoothObjective& objective, std::vector<double> x, double largest_move, double gradient_unit);
  bool iterate() override;
  Memory memory() const override { return {{"radius", {radius_}}}; }
  void remember(const Memory& memory) override { radius_ = memory.at("radius").at(0); }

  std::int64_t products() const { return products_; }  ///< Number of products with the Hessian

 private:
  struct Step {
    std::vector<double> move;
    double predicted_decrease = 0;  ///< Decrease predicted by the model
    bool to_edge = false;
  };
  Step solve_model();
  double gain(const Step& step) const;

  SmoothObjective& smooth_;
  double largest_move_, gradient_unit_, radius_ = 0;
  std::int64_t products_ = 0;
  Point next_;
};

}  // namespace lichtenberg::minimize
