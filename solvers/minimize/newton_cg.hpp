#pragma once

#include "solvers/minimize/minimizer.hpp"

namespace lichtenberg::minimize {

/// Newton's method in a trust region: the quadratic model is minimized by preconditioned conjugate gradients until it
/// is accurate enough, reaches the region's edge or finds negative curvature, along which it goes to the edge (Steihaug
/// 1983). The region is a ball in the preconditioner's norm.
class NewtonCg : public Minimizer {
 public:
  /// `largest_move`: of a component in the first iteration; `gradient_unit`: what is a large gradient.
  NewtonCg(SmoothObjective& objective, std::vector<double> x, double largest_move, double gradient_unit);
  bool iterate() override;
  Memory memory() const override { return {{"radius", {radius_}}}; }
  void remember(const Memory& memory) override { radius_ = memory.at("radius").at(0); }

  std::int64_t products() const { return products_; }  ///< with the Hessian

 private:
  struct Step {
    std::vector<double> move;
    double promise = 0;  ///< by how much the model goes down
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
