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

/// A number of a run's final summary.
struct Quantity {
  std::string name;
  double value = 0;
  std::string unit;
};

/// What a run says of itself when it is over, or as far as it came: for people, line by line, and as numbers for the
/// result file. The numbers hold no timings, so that equal runs leave equal numbers.
struct Summary {
  struct Line {
    std::string label, text;
  };
  std::string title;  ///< follows the name of the result file: "holds the run up to t = ..."
  std::vector<Line> lines;
  std::vector<Quantity> quantities;
  std::string goal;  ///< the quantity that says whether what the scene aims at was reached: 1 or 0
  /// Why the result may be unsafe to use. Up to the first ": " each says what is wrong, in a few words that pictures
  /// show, and after that the limit and the remedy.
  std::vector<std::string> warnings{};
};

/// Progress of a motion in a measure that grows at a steady rate, and its value at the end (infinite: unknown).
struct Way {
  double done = 0, whole = 0;
};

/// What a run keeps of an instant beside its frame.
struct Kept {
  Checkpoint checkpoint;
  ColumnGroup history;
};

/// What ends Motion::advance_to where it was told to stop at an instant that it has no checkpoint of.
struct Paused {};

/// A way to carry a scene on, in time or towards rest. `lichtenberg run` drives any of them: it asks for frames,
/// records them, and makes checkpoints from which another Motion of the same scene goes on bit for bit.
class Motion {
 public:
  virtual ~Motion() = default;

  /// s since the start; of a minimization the number of the iteration.
  virtual double time() const = 0;
  virtual std::string time_unit() const { return "s"; }  ///< "1" where time counts iterations
  /// The time at which the next frame is due, later than now.
  virtual double next_frame() const = 0;
  /// The time at which all is over at the latest; infinite if nobody knows.
  virtual double end_time() const = 0;
  /// Carries the scene on to `time`, or less far if it is over before. `pause` is asked between two steps; true: stop
  /// here. A motion whose checkpoints are not exact at any instant then throws Paused, and is of no use any more.
  /// Throws InputError if the first instant cannot be computed, Failure if the scene cannot be carried on.
  virtual void advance_to(double time, const std::function<bool()>& pause) = 0;
  /// Nothing is left to be done.
  virtual bool finished() = 0;
  /// Whether a checkpoint changes nothing of what follows, whenever it is made. If not, checkpoints belong to frames
  /// that a resumed run makes them at too.
  virtual bool exact_anywhere() const { return false; }

  /// What there is to see now.
  virtual Frame frame() = 0;
  /// frame() of now, to be called once, on any thread, while this motion goes on.
  virtual std::function<Frame()> frame_later() {
    return [now = std::make_shared<Frame>(frame())] { return std::move(*now); };
  }
  /// The potential now; empty without a field.
  virtual std::optional<laplace::Field> field() { return {}; }
  /// How far it is, for a line that shows the progress.
  virtual std::string progress() = 0;
  /// Progress for an estimate of the time that is left.
  virtual Way way() { return {time(), end_time()}; }

  /// All there is. One restored from it goes on bit for bit as this one does, which may have to forget something for
  /// it.
  virtual Checkpoint checkpoint() = 0;
  /// A checkpoint without forgetting, for a motion that fails on its way: one restored from it goes on as this one does
  /// but for solvers' tolerances. Empty where that is not offered.
  virtual std::optional<Checkpoint> snapshot() { return {}; }
  /// Puts the motion where the checkpoint was made. Throws Failure if that was of another scene.
  virtual void restore(const Checkpoint& checkpoint) = 0;

  /// What there is to say to the user when a checkpoint is made: promises that are not kept.
  virtual std::vector<std::string> warnings() { return {}; }
  /// Rows that have been noted since the last call beside frames, at a pace of their own; a group of no columns: none.
  virtual ColumnGroup take_history() { return {}; }
  /// checkpoint() and take_history() of now, as frame_later; what is left to be called is called in the order of
  /// asking.
  virtual std::function<Kept()> keep_later() {
    return [now = std::make_shared<Kept>(Kept{checkpoint(), take_history()})] { return std::move(*now); };
  }
  /// Whether a core is free for whoever calls these meanwhile.
  virtual bool leaves_a_core() const { return false; }
  /// What is known of the last frame once all is over.
  virtual std::vector<ColumnGroup> findings() { return {}; }
  virtual Summary summary() = 0;
  /// Wall time (s) since this program started, by activity.
  virtual std::map<std::string, double> seconds() const = 0;
};

}  // namespace lichtenberg
