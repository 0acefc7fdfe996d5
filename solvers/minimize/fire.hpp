#pragma once

#include "solvers/minimize/minimizer.hpp"

namespace lichtenberg::minimize {

/// Fast inertial relaxation engine: molecular dynamics of unit masses. The velocity is mixed with the direction of the
/// force, the time step grows while the motion goes downhill, and the motion stops when it does not (Bitzek et al.
/// 2006; semi-implicit Euler and the half step back of Guenole et al. 2020).
class Fire : public Minimizer {
 public:
  /// Starts at x. `largest_step`: time step, below 2 over the square root of the largest curvature; `largest_move`:
  /// change of a component in one iteration.
  Fire(Objective& objective, std::vector<double> x, double largest_step, double largest_move);
  bool iterate() override;
  Memory memory() const override;
  void remember(const Memory& memory) override;

 private:
  void stop();

  double largest_step_, largest_move_;
  double step_, mixing_;
  double taken_ = 0;  ///< Last step, possibly shortened; half of it is taken back when the motion stops
  int downhill_ = 0;  ///< Iterations since the velocity last went uphill
  std::vector<double> velocity_;
  Point next_;
};

}  // namespace lichtenberg::minimize
