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

/// Integrator that splits mechanics and field, in coupling steps that end with a field solve
/// (docs/numerics/coupling.md). Between solves the electric force is extrapolated linearly in time from the last two
/// solves. The solve at the end of a step gives the force's defect. The displacement by this defect, and the error of
/// charges through resistors, decide whether the step is accepted and how long the next one is. Contacts are located as
/// events. A merge of equipotential groups ends a step. A split needs no solve in the first half of a step without
/// resistors; otherwise it ends the step as well. With a predictor (an approximate solver on a coarser grid) these
/// solves use it, and field solves at intervals check and correct them.
class Split : public Stepper {
 public:
  explicit Split(StepperContext context);
  void begin(double time) override;
  void advance(double time, double end) override;
  bool limits_moves() const override { return true; }
  void pass_corner(double time, const std::vector<Vec3>& force_before) override { restart(time, force_before); }
  void save(Checkpoint& checkpoint) const override;
  void restore(const Checkpoint& checkpoint) override;

 private:
  /// State saved for the rollback of predicted steps (steps whose field solves use the coarser grid).
  struct Start {
    Bodies bodies;
    ElectricalState electrical_state;
    Counters counters;
  };
  Start start() const;
  void rollback(const Start& start);
  double predict(double since, double target);
  double try_prediction(double time, double end);
  double try_step(double time, double end, FieldGrid grid);
  double step_within_gaps(double time, double step) const;
  double step_end(double time, double step, double end) const;
  /// Result of a motion of the bodies up to the next field solve, or up to an event.
  struct Moved {
    /// Time (s) at the end of the motion, and earliest time (s) at which contacts may have been due to close or open.
    double reached = 0, due_since = 0;
    std::optional<std::vector<int>> interacting;  ///< bodies that CVODE moved; no value: all
  };
  Moved move(double time, double target);
  double wait(double time, double target, const ContactPrediction& prediction, const Moved& moved);
  std::optional<std::vector<int>> moved_by_cvode(std::span<const double> travel, std::span<const double> reach) const;
  double advance(double time, double target, const Events& events, const std::optional<std::vector<int>>& interacting);
  bool pass_event(const Moved& moved, FieldGrid grid);
  void correct_after_mergers(const Moved& moved, std::span<const Merger> mergers);
  const effects::ExtrapolatedField& extrapolated() const { return context_.electrics->now().extrapolated; }
  void find_extrapolated_forces(double time, std::vector<Vec3>& force) const;
  double error(double since, const Trial& trial, const std::vector<Vec3>& assumed) const;
  void accept(Trial trial, double error);
  void reject(double time, double reached, double error, FieldGrid grid);
  void restart(double time, const std::vector<Vec3>& force_before);
  double step_after(const std::vector<Vec3>& force_before, int first, int end) const;

  struct SavedMotion {
    std::vector<double> position, momentum;  ///< as in Bodies
  };

  StepperContext context_;
  Cvode cvode_;
  FreeFlight flight_;
  DefectCorrection correction_;
  MergerScheduler mergers_;
  std::span<const double> drag_;  ///< kg/s, linear part, a lower bound of the drag
  double largest_step_, shortest_step_;
  double shortest_gap_;    ///< m, contact gap
  double step_ = 0;        ///< s, between solves, set by the error control; 0: not yet estimated
  double prediction_ = 0;  ///< s, interval of predicted steps; 0: not yet estimated
  // Scratch memory:
  SavedMotion before_;                  ///< at the start of the present step
  std::vector<double> travel_, reach_;  ///< m
  std::vector<Vec3> assumed_;           ///< N, extrapolated to the end of a step
  std::vector<Vec3> old_force_;         ///< N, before a jump
};

}  // namespace lichtenberg::mechanics
