#pragma once

#include "solvers/minimize/minimizer.hpp"

namespace lichtenberg::minimize {

/// Minimizer FIRE (fast inertial relaxation engine): molecular dynamics of unit masses with adaptive damping. Each step
/// mixes the velocity with the direction of the force. After 20 iterations downhill the time step grows, up to its
/// limit. As soon as the motion goes uphill, the velocity is set to 0 and the time step is shortened.
/// Source: Bitzek et al. 2006, with semi-implicit Euler steps and the half step back of Guenole et al. 2020.
class Fire : public Minimizer {
 public:
  /// Starts the minimization at x. `largest_step`: upper limit of the time step. For stability it must be below 2 over
  /// the square root of the Hessian's largest eigenvalue. `largest_move`: upper limit of the change of a component of x
  /// in one time step.
  Fire(Objective& objective, std::vector<double> x, double largest_step, double largest_move);
  bool iterate() override;
  Memory memory() const override;
  void remember(const Memory& memory) override;

 private:
  /// Stops an uphill motion: takes back half of the last step, sets the velocity to 0 and halves the time step, to no
  /// less than 1e-3 of its limit.
  void stop();

  double largest_step_, largest_move_;
  double step_, mixing_;
  double taken_ = 0;  ///< Last step, possibly shortened; half of it is taken back when the motion stops
  int downhill_ = 0;  ///< Iterations since the velocity last went uphill
  std::vector<double> velocity_;
  Point next_;
};

}  // namespace lichtenberg::minimize
