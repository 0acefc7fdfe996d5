#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "src/mechanics/defect_correction.hpp"
#include "src/mechanics/free_flight.hpp"
#include "src/mechanics/merger_scheduler.hpp"
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
  /// All that predicted steps change: a way back.
  struct Start {
    Bodies bodies;
    Charging charging;
    Counters counters;
  };
  Start start() const;
  void go_back(const Start& start);
  double predict(double since, double target);
  double try_prediction(double time, double end);
  double try_step(double time, double end, FieldGrid grid);
  double step_within_gaps(double time, double step) const;
  double step_end(double time, double step, double end) const;
  /// A move of the bodies from solve to solve, or to an event.
  struct Moved {
    double reached = 0, due_since = 0;       ///< s; the second: since when contacts may have been due at its end
    std::optional<std::vector<int>> pushed;  ///< that CVODE moved; empty: all
  };
  Moved move(double time, double target);
  double wait(double time, double target, const Lookahead& ahead, const Moved& moved);
  std::optional<std::vector<int>> moved_by_cvode(std::span<const double> travel, std::span<const double> reach) const;
  double advance(double time, double target, const Events& events, const std::optional<std::vector<int>>& pushed);
  bool pass_event(const Moved& moved, FieldGrid grid);
  void make_up_merger(const Moved& moved, std::span<const Merger> mergers);
  const effects::HeldField& held() const { return at_.electrics->now().held; }
  void find_held_forces(double time, std::vector<Vec3>& force) const;
  double error(double since, const Trial& trial, const std::vector<Vec3>& assumed) const;
  void accept(Trial trial, double error);
  void reject(double time, double reached, double error, FieldGrid grid);
  void restart(double time, const std::vector<Vec3>& force_before);
  double step_after(const std::vector<Vec3>& force_before, int first, int end) const;

  struct Places {
    std::vector<double> position, momentum;  ///< as in Bodies
  };

  Workplace at_;
  Cvode cvode_;
  FreeFlight flight_;
  DefectCorrection correction_;
  MergerScheduler mergers_;
  std::span<const double> drag_;  ///< kg/s, linear part: a lower bound
  double largest_step_, shortest_step_;
  double shortest_gap_;    ///< m
  double step_ = 0;        ///< s, allowed by the error control, from solve to solve; 0: to be estimated
  double prediction_ = 0;  ///< s, how long predictions are good for; 0: to be estimated
  // Kept for their memory alone:
  Places before_;                       ///< the step that is tried
  std::vector<double> travel_, reach_;  ///< m
  std::vector<Vec3> assumed_;           ///< N, at a step's end
  std::vector<Vec3> old_force_;         ///< N, before a jump
};

}  // namespace lichtenberg::mechanics
