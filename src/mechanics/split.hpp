#pragma once

#include <optional>
#include <span>
#include <utility>
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
  double step_end(double time, double step, double end) const;
  double move(double time, double target);
  double wait(double time, double target, const Lookahead& ahead);
  std::optional<std::vector<int>> moved_by_cvode(std::span<const double> travel, std::span<const double> reach) const;
  double advance(double time, double target, const Events& events);
  bool pass_event(double time, FieldGrid grid);
  void make_up(LastFall& last, int body, double dt, Vec3 force, Vec3 rate);
  void make_up_defect(double dt, const std::vector<Vec3>& assumed, std::span<const int> fixed);
  void make_up_step(double dt, const std::vector<Vec3>& assumed);
  void make_up_correction(double dt, const std::vector<Vec3>& predicted);
  /// Where the two of a merger are (of one with a terminal twice the conductor), and how late it is: less than 0 of one
  /// that is early.
  struct Lateness {
    double by = 0;  ///< s
    Vec3 one, other;
  };
  std::vector<Lateness> lateness(double time, std::span<const Merger> mergers) const;
  double late_by(int body, std::span<const Lateness> mergers) const;
  void make_up_wait(double time, std::span<const Merger> mergers, const std::vector<Vec3>& force_before);
  void make_up_far(std::span<const Lateness> lateness, const std::vector<Vec3>& force_before);
  void learn_patience(const std::vector<Vec3>& force_before);
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
  std::span<const double> drag_;  ///< kg/s, linear part: a lower bound
  double largest_step_, shortest_step_;
  double shortest_gap_;    ///< m
  double step_ = 0;        ///< s, allowed by the error control, from solve to solve; 0: to be estimated
  double prediction_ = 0;  ///< s, how long predictions are good for; 0: to be estimated
  double patience_ = 0;    ///< s, how long a merger may wait for others
  double due_since_ = 0;   ///< s, since when contacts may have been due in the last move
  std::optional<std::vector<int>> pushed_;  ///< that CVODE moved in the last move; empty: all
  // Kept for their memory alone:
  Places before_;                       ///< the step that is tried
  std::vector<double> travel_, reach_;  ///< m
  std::vector<Vec3> assumed_;           ///< N, at a step's end
  std::vector<Vec3> old_force_;         ///< N, before a jump
};

}  // namespace lichtenberg::mechanics
