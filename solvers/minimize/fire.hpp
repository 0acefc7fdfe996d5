#pragma once

#include "solvers/minimize/minimizer.hpp"

namespace lichtenberg::minimize {

/// Fast inertial relaxation engine: molecular dynamics of unit masses whose velocity is turned towards the force, sped
/// up while it goes downhill and stopped when it does not (Bitzek et al. 2006; semi-implicit Euler and the half step
/// back of Guenole et al. 2020).
class Fire : public Minimizer {
 public:
  /// `largest_step`: of time, below 2 over the square root of the largest curvature; `largest_move`: of a component in
  /// one iteration.
  Fire(Objective& objective, std::vector<double> x, double largest_step, double largest_move);
  bool iterate() override;
  Memory memory() const override;
  void remember(const Memory& memory) override;

 private:
  void stop();

  double largest_step_, largest_move_;
  double step_, mixing_;
  double taken_ = 0;  ///< the last step, which may have been cut: where to go back on it
  int downhill_ = 0;  ///< iterations since the velocity last went uphill
  std::vector<double> velocity_;
  Point next_;
};

}  // namespace lichtenberg::minimize
