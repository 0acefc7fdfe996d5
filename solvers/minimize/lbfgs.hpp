#pragma once

#include <deque>

#include "solvers/minimize/minimizer.hpp"

namespace lichtenberg::minimize {

/// Limited-memory BFGS (Nocedal 1980) with backtracking: a step is taken if it lowers the value by a share of what the
/// slope promises (Armijo 1966).
class Lbfgs : public Minimizer {
 public:
  /// `largest_move`: of a component in one iteration; `first_step`: of the first step, along the gradient.
  Lbfgs(Objective& objective, std::vector<double> x, double first_step, double largest_move);
  bool iterate() override;
  Memory memory() const override;
  void remember(const Memory& memory) override;

 private:
  struct Correction {
    std::vector<double> move, change;  ///< of x, of the gradient
    double product = 0;
  };
  std::vector<double> direction() const;
  bool search(const std::vector<double>& direction);
  void learn();

  double first_step_, largest_move_;
  std::deque<Correction> corrections_;
  Point next_;
};

}  // namespace lichtenberg::minimize
