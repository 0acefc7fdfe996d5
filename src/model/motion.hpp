#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "solvers/laplace/problem.hpp"
#include "src/model/checkpoint.hpp"
#include "src/model/frame.hpp"

namespace lichtenberg {

/// A number in a run's final summary.
struct Quantity {
  std::string name;
  double value = 0;
  std::string unit;
};

/// Summary of a run at its end or at an interruption: lines of text, and numbers for the result file. The numbers
/// contain no timings, so identical runs have identical numbers.
struct Summary {
  struct Line {
    std::string label, text;
  };
  std::string title;  ///< follows the name of the result file: "holds the run up to t = ..."
  std::vector<Line> lines;
  std::vector<Quantity> quantities;
  std::string goal;  ///< quantity that is 1 if the scene's goal was reached, otherwise 0
  /// Reasons why the result may be unreliable. The text of each up to the first ": " describes the problem in a few
  /// words for pictures. The limit and the remedy follow.
  std::vector<std::string> warnings{};
};

/// Progress of a motion in a measure that grows at a steady rate, and its value at the end (infinite: unknown).
struct ProgressMeasure {
  double done = 0, whole = 0;
};

/// Data that a run saves at an instant in addition to its frame.
struct SavedState {
  Checkpoint checkpoint;
  ColumnGroup history;
};

/// Exception that ends Motion::advance_to after a stop request at an instant without an exact checkpoint.
struct Paused {};

/// Advances a scene in time or towards rest. `lichtenberg run` drives any Motion. It records its frames and makes
/// checkpoints, from which another Motion of the same scene continues with bitwise identical results.
class Motion {
 public:
  virtual ~Motion() = default;

  /// Time (s) since the start; the number of the iteration for a minimization.
  virtual double time() const = 0;
  virtual std::string time_unit() const { return "s"; }  ///< "1" if time counts iterations
  /// Returns the time of the next frame, later than the current time.
  virtual double next_frame() const = 0;
  /// Returns the latest time at which the motion ends; infinite if it is unknown.
  virtual double end_time() const = 0;
  /// Advances the scene to `time`, or to its end if that is earlier. `pause` is called between two steps; true: stop
  /// here. A motion that has no exact checkpoint at this instant then throws Paused and cannot be used again. Throws
  /// InputError if the first instant cannot be computed, Failure if a later one cannot.
  virtual void advance_to(double time, const std::function<bool()>& pause) = 0;
  /// Returns true if the motion has ended.
  virtual bool finished() = 0;
  /// Returns true if a checkpoint never changes later results. Otherwise checkpoints are made at frames at which a
  /// resumed run makes them too.
  virtual bool exact_anywhere() const { return false; }

  /// Returns the frame of the current instant.
  virtual Frame frame() = 0;
  /// Returns a function that makes the frame of the current instant. It is called once, on any thread, while this
  /// motion continues.
  virtual std::function<Frame()> frame_later() {
    return [now = std::make_shared<Frame>(frame())] { return std::move(*now); };
  }
  /// Returns the potential at the current instant; empty without a field.
  virtual std::optional<laplace::Field> field() { return {}; }
  /// Describes the progress for a status line.
  virtual std::string progress() = 0;
  /// Returns the progress for an estimate of the remaining time.
  virtual ProgressMeasure progress_measure() { return {time(), end_time()}; }

  /// Returns the complete state. This motion and a motion restored from the state continue with bitwise identical
  /// results; for this, cached data may be discarded.
  virtual Checkpoint checkpoint() = 0;
  /// Returns a checkpoint that discards nothing, for a motion that fails later. A motion restored from it agrees within
  /// solver tolerances. Empty if it is not supported.
  virtual std::optional<Checkpoint> snapshot() { return {}; }
  /// Restores the state of a checkpoint. Throws Failure if it belongs to another scene.
  virtual void restore(const Checkpoint& checkpoint) = 0;

  /// Returns warnings for the user at a checkpoint, such as exceeded error bounds.
  virtual std::vector<std::string> warnings() { return {}; }
  /// Returns the rows recorded since the last call at intervals of their own, independent of frames. A group without
  /// columns: none.
  virtual ColumnGroup take_history() { return {}; }
  /// Returns a function that makes checkpoint() and take_history() of the current instant, as frame_later() does. Such
  /// functions are called in the order in which they were requested.
  virtual std::function<SavedState()> saved_state_later() {
    return [now = std::make_shared<SavedState>(SavedState{checkpoint(), take_history()})] { return std::move(*now); };
  }
  /// Returns true if a core is free for a thread that calls these functions.
  virtual bool leaves_a_core() const { return false; }
  /// Returns quantities of the last frame that are known once the motion has ended.
  virtual std::vector<ColumnGroup> findings() { return {}; }
  virtual Summary summary() = 0;
  /// Returns the wall time (s) since this program started, by activity.
  virtual std::map<std::string, double> seconds() const = 0;
};

}  // namespace lichtenberg
