#pragma once

#include <string>
#include <vector>

#include "src/model/model.hpp"

namespace lichtenberg::mechanics {

/// Checks the steps of an integrator of conductors. Their committed lengths add up to the interval, and no body moves
/// further in one step than the effects allow (Model::largest_move).
class StepCheck {
 public:
  /// `model` must outlive the object. `integrator`: name for messages. `checks_moves`: false for an integrator that
  /// limits the displacement of each of its steps itself (Stepper::limits_moves).
  StepCheck(const Model& model, std::string integrator, bool checks_moves);

  /// Starts the check of an interval at the current positions.
  void begin();
  /// Compares the positions with those of the last call. Throws Failure if a body has moved too far.
  void between_steps();
  /// Adds the length dt (s) of a committed step.
  void commit(double dt) { committed_ += dt; }
  /// Ends the interval from `begin` to `end` (s). Throws Failure if the committed steps do not fill it, or if a body
  /// has moved too far in the last one.
  void end(double begin, double end);

 private:
  const Model& model_;
  std::string integrator_;
  double largest_move_;           ///< m; infinite: not checked
  double committed_ = 0;          ///< s, since begin()
  std::vector<double> position_;  ///< m, [N * dimension], at the last call of between_steps(); empty: not checked
};

}  // namespace lichtenberg::mechanics
