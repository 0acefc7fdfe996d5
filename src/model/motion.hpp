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

/// A named number with a unit in the final summary of a run.
struct Quantity {
  std::string name;
  double value = 0;
  std::string unit;
};

/// Summary of a run at its end or at an interruption: lines of text, and numbers for the result file. Timings are not
/// among the numbers, so identical runs have identical numbers.
struct Summary {
  /// A line of the summary: a label and the text after it.
  struct Line {
    std::string label, text;
  };
  std::string title;  ///< text after the name of the result file: "holds the run up to t = ..."
  std::vector<Line> lines;
  std::vector<Quantity> quantities;
  std::string goal;  ///< name of the quantity that is 1 if the scene's goal was reached, otherwise 0
  /// Reasons why the result may be unreliable. The text of each up to the first ": " describes the problem in a few
  /// words for pictures. The limit and the remedy follow.
  std::vector<std::string> warnings{};
};

/// Progress of a run as an amount of work that grows at a steady rate: `done` at the current instant and `whole` at the
/// end (infinite: unknown).
struct ProgressMeasure {
  double done = 0, whole = 0;
};

/// Data that a run saves at an instant in addition to its frame: a checkpoint, and the rows of its time series since
/// the last saved state.
struct SavedState {
  Checkpoint checkpoint;
  ColumnGroup history;
};

/// Exception that Motion::advance_to throws when it is to stop at an instant at which no exact checkpoint can be made.
struct Paused {};

/// Interface of a simulation that advances a scene in time, or towards rest by minimization. `lichtenberg run` drives
/// any Motion, records its frames and saves checkpoints. Another Motion of the same scene continues from the state of
/// checkpoint() with bitwise identical results.
class Motion {
 public:
  virtual ~Motion() = default;

  /// Returns the time since the start in units of time_unit(); the number of the iteration for a minimization.
  virtual double time() const = 0;
  virtual std::string time_unit() const { return "s"; }  ///< "1" if time counts iterations
  /// Returns the time of the next frame, later than the current time.
  virtual double next_frame() const = 0;
  /// Returns the time at which the motion ends at the latest; infinite if it is unknown.
  virtual double end_time() const = 0;
  /// Advances the scene to `time`, or to its end if the end is earlier. `pause` is called between two steps; if it
  /// returns true, the motion stops there. A motion without an exact checkpoint at this instant then throws Paused and
  /// cannot be used again. Throws InputError if the first instant cannot be computed, Failure if a later one cannot.
  virtual void advance_to(double time, const std::function<bool()>& pause) = 0;
  /// Returns true if the motion has ended.
  virtual bool finished() = 0;
  /// Returns true if making a checkpoint never changes later results. Otherwise checkpoints are made only at frames at
  /// which a resumed run makes them too.
  virtual bool exact_anywhere() const { return false; }

  /// Returns the frame (recorded state) of the current instant.
  virtual Frame frame() = 0;
  /// Returns a function that makes the frame of the current instant. The function may be called once, on any thread,
  /// and while this motion continues.
  virtual std::function<Frame()> frame_later() {
    return [now = std::make_shared<Frame>(frame())] { return std::move(*now); };
  }
  /// Returns the electric potential at the current instant; empty without a field.
  virtual std::optional<laplace::Field> field() { return {}; }
  /// Returns a text about the progress for a status line.
  virtual std::string progress() = 0;
  /// Returns the progress as an amount of work, for an estimate of the remaining wall time. By default the work is
  /// proportional to the simulated time.
  virtual ProgressMeasure progress_measure() { return {time(), end_time()}; }

  /// Returns the complete state. This motion and a motion restored from the state continue with bitwise identical
  /// results. For this purpose this motion may discard cached data.
  virtual Checkpoint checkpoint() = 0;
  /// Returns a checkpoint without discarding cached data, to be saved if the motion fails later. Results of a motion
  /// restored from it agree within solver tolerances. Empty if it is not supported.
  virtual std::optional<Checkpoint> snapshot() { return {}; }
  /// Restores the state of a checkpoint. Throws Failure if the checkpoint does not fit the scene or this version of the
  /// program.
  virtual void restore(const Checkpoint& checkpoint) = 0;

  /// Returns warnings for the user, such as exceeded error bounds. The run prints them whenever it saves a checkpoint.
  virtual std::vector<std::string> warnings() { return {}; }
  /// Returns the rows of the motion's time series since the last call, and removes them. The rows have intervals of
  /// their own, independent of frames. A group without columns: no time series.
  virtual ColumnGroup take_history() { return {}; }
  /// Returns a function that makes checkpoint() and take_history() of the current instant. The function may be called
  /// once, on any thread, and while this motion continues. Several such functions must be called in the order in which
  /// they were returned.
  virtual std::function<SavedState()> saved_state_later() {
    return [now = std::make_shared<SavedState>(SavedState{checkpoint(), take_history()})] { return std::move(*now); };
  }
  /// Returns true if the motion leaves a CPU core free, for a thread that calls the functions of frame_later() and
  /// saved_state_later().
  virtual bool leaves_a_core() const { return false; }
  /// Returns results of the finished motion, such as properties of a minimized packing, for the result file.
  virtual std::vector<ColumnGroup> findings() { return {}; }
  virtual Summary summary() = 0;
  /// Returns the wall time (s) that this process has spent, by activity.
  virtual std::map<std::string, double> seconds() const = 0;
};

}  // namespace lichtenberg
