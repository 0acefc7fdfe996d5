#pragma once

#include <vector>

#include "src/mechanics/stepper.hpp"

namespace lichtenberg::mechanics {

/// Mechanics by CVODE, the field once a coupling step (see README.md). Within a step the electric force is extrapolated
/// linearly in time from the last two solves; at its end the field is solved, and the force's defect, turned into a
/// displacement, decides whether the step stands and how long the next one is. Contacts end a step where they happen.
class Split : public Stepper {
 public:
  explicit Split(Workplace workplace);
  void begin(double time) override;
  void advance(double time, double end) override;
  void save(Checkpoint& checkpoint) const override;
  void restore(const Checkpoint& checkpoint) override;

 private:
  double try_step(double time, double end);
  double move(double time, double target);
  std::vector<Vec2> held_forces(double time) const;
  double error(double time, double dt) const;
  void accept(double dt, double error, bool cut_short);
  void reject(double dt, double error);
  void restart(const std::vector<Vec2>& force_before);

  Workplace at_;
  Cvode cvode_;
  std::vector<double> drag_;     ///< kg/s
  double largest_step_, shortest_step_;
  double step_ = 0;              ///< s, the next one; 0: to be estimated
  std::vector<Vec2> force_;      ///< N, at the step's start
  std::vector<Vec2> rate_;       ///< N/s, of the extrapolation
  bool rate_known_ = false;      ///< the rate is that of the last step; if not it is 0
};

}  // namespace lichtenberg::mechanics
