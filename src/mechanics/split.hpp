#pragma once

#include <vector>

#include "src/mechanics/free_flight.hpp"
#include "src/mechanics/stepper.hpp"

namespace lichtenberg::mechanics {

/// Mechanics and field apart, the field once a coupling step (see README.md). Between solves the electric force is
/// extrapolated linearly in time from the last two; at a step's end the field is solved, and the force's defect, turned
/// into a displacement, decides whether the step stands and how long the next one is. Contacts are located as events:
/// mergers of groups end a step, partings need no solve. With a predictor these solves are on its coarser grid, and a
/// field solve now and then checks and corrects them.
class Split : public Stepper {
 public:
  explicit Split(Workplace workplace);
  void begin(double time) override;
  void advance(double time, double end) override;
  void save(Checkpoint& checkpoint) const override;
  void restore(const Checkpoint& checkpoint) override;

 private:
  /// All that a prediction changes.
  struct Snapshot {
    double time = 0;
    Bodies bodies;
    std::vector<Vec2> force;
    std::vector<double> charge;
    Counters counters;
    Checkpoint rest;
  };
  Snapshot snapshot(double time) const;
  void go_back(const Snapshot& start);
  void predict(double time, double target);
  double try_prediction(double time, double end);
  double try_step(double time, double end);
  double step_end(double time, double step, double end) const;
  double move(double time, double target);
  bool pass_event(double time);
  std::vector<Vec2> held_forces(double time) const;
  std::vector<double> extrapolated_charges(double time) const;
  void remember_field(double time);
  void hold(double time, std::vector<Vec2> force, std::vector<double> charge);
  double error(double since, double until, const std::vector<Vec2>& assumed) const;
  void accept(double time, double error);
  void reject(double time, double reached, double error);
  void restart(double time, const std::vector<Vec2>& force_before);

  Workplace at_;
  Cvode cvode_;
  FreeFlight flight_;
  std::vector<double> drag_;  ///< kg/s
  double largest_step_, shortest_step_;
  double shortest_gap_;  ///< m
  double step_ = 0;      ///< s, allowed by the error control, from solve to solve; 0: to be estimated
  // The extrapolation: what the last solve found, and its rate of change.
  double solved_at_ = 0;                      ///< s
  std::vector<Vec2> force_, force_rate_;      ///< N, N/s
  std::vector<double> charge_, charge_rate_;  ///< C, by the field (D 5.4), and A
  bool rates_known_ = false;                  ///< from the last two solves; if not they are 0
  double prediction_ = 0;                     ///< s, how long predictions are good for; 0: to be estimated
};

}  // namespace lichtenberg::mechanics
