#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "solvers/parallel/task_queue.hpp"
#include "src/model/motion.hpp"
#include "src/record/recorder.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {

/// Checks that a scene can be run on this machine, and chooses the field method for a requested accuracy. Returns the
/// scene with the chosen options. Throws InputError if the scene cannot be run, and the exceptions of the field solver.
Scene prepare_run(Scene scene);

/// Run of a scene, frame by frame, from its start or last checkpoint to its end, with an optional result file.
///
/// A checkpoint may discard state of the motion that it cannot store, which changes the last digits of the following
/// results. Unless the motion's checkpoints are exact, they are made only at frames with fixed indices and at the end.
/// A resumed run then discards the same state at the same instants and is bitwise identical to an uninterrupted one. A
/// recorded run on one process that fails leaves a checkpoint at its last frame.
///
/// If the motion leaves a core free, another thread assembles and writes frames and checkpoints, in order and at most
/// one frame behind. The results are bitwise identical.
class RecordedRun {
 public:
  /// Makes the motion of a prepared scene and restores the recorder's checkpoint, if it has one. `recorder`: no value
  /// if nothing is recorded; the results are the same. `warn` receives warnings for the user.
  RecordedRun(Scene scene, std::optional<Recorder> recorder, std::function<void(const std::string&)> warn);

  /// Records the frame at the start of a new run. Call it once, before all other steps.
  void begin();
  /// Advances to the next frame, or to the end if that is earlier, and records it. `pause`: as for
  /// Motion::advance_to(), with its exceptions. After an exception the file holds the run up to saved_instant().
  void to_next_frame(const std::function<bool()>& pause);
  /// Returns true if the motion has ended.
  bool finished() const { return finished_; }
  /// Returns true if a checkpoint of the last frame is in the result file or about to be written there.
  bool saved() const { return saved_; }
  /// Saves a checkpoint of the current instant; at the end of the motion, its summary too.
  void save();
  /// Completes the file of a finished run, and unlocks it.
  void end();
  /// Ends the run before its end: writes all frames so far, without a new checkpoint, and unlocks the file. Returns the
  /// last instant and that of the checkpoint in words. Requires a recorder.
  std::pair<std::string, std::string> stop();

  /// Returns the instant of the checkpoint in the file; empty if there is none.
  std::string saved_instant() const {
    return recorder_ && recorder_->saved_time() ? instant(*recorder_->saved_time()) : "";
  }
  /// Returns true if the file of a run that has ended or stopped contains all frames. Frames of long runs are in
  /// further files until the end.
  bool is_in_one_file() const { return is_in_one_file_; }

  const Scene& scene() const { return scene_; }
  Motion& motion() { return *motion_; }
  /// Returns the number of frames of the run so far.
  std::int64_t frames() const { return frames_; }
  /// Returns the summary of a finished run.
  const Summary& summary() const { return summary_; }
  /// Returns the wall time (s) since the start, by activity.
  std::map<std::string, double> seconds() const;

 private:
  void update_frame();
  void record();
  void save_last_state();
  void save_in_background();
  void save_end();
  std::optional<laplace::Field> field();
  std::string instant(double time) const { return instant_in_words(time, motion_->time_unit()); }

  Scene scene_;
  std::optional<Recorder> recorder_;
  std::function<void(const std::string&)> warn_;
  /// All frames of the run so far, including those still to be written.
  std::int64_t frames_;
  std::unique_ptr<Motion> motion_;
  std::function<Frame()> make_frame_;  ///< Null if nothing is recorded
  bool finished_ = false;
  bool saved_ = true;
  /// Whether the file holds the end of the run.
  bool end_saved_ = false;
  Summary summary_;
  /// State of the last frame if it is not saved.
  std::optional<Checkpoint> last_state_;
  double recording_seconds_ = 0;
  bool is_in_one_file_ = true;
  /// The frame and its checkpoint.
  static constexpr std::size_t tasks_per_frame = 2;
  /// Tasks that write the file; destroyed first because they use the other members.
  parallel::TaskQueue write_queue_;
};

}  // namespace lichtenberg
