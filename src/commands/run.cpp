#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <memory>
#include <utility>

#include "solvers/error.hpp"
#include "solvers/parallel/petsc.hpp"
#include "solvers/parallel/task_queue.hpp"
#include "solvers/stopwatch.hpp"
#include "src/commands/commands.hpp"
#include "src/commands/device.hpp"
#include "src/commands/field_problem.hpp"
#include "src/commands/interruption.hpp"
#include "src/commands/json_output.hpp"
#include "src/commands/output.hpp"
#include "src/commands/progress.hpp"
#include "src/commands/python.hpp"
#include "src/commands/reading.hpp"
#include "src/commands/start_from.hpp"
#include "src/commands/streams.hpp"
#include "src/effects/field_choice.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/granular/device/device.hpp"
#include "src/granular/granular_motion.hpp"
#include "src/granular/summary.hpp"
#include "src/mechanics/simulation.hpp"
#include "src/record/atomic_file.hpp"
#include "src/record/recorder.hpp"
#include "src/scene/effect_kind.hpp"
#include "src/scene/scene.hpp"
#include "src/statics/minimization.hpp"

namespace lichtenberg {
namespace {

struct RunArguments {
  std::string scene, file, device, from;
  std::vector<std::string> settings;
  std::optional<int> frame;
  bool resume = false, overwrite = false, quiet = false;
};

Scene requested_scene(const RunArguments& request) {
  const auto read = [&](const std::vector<Conductor>& bodies) {
    return read_scene_for(request.scene, request.device, request.settings, Interruption::requested, bodies);
  };
  Scene scene = read_started(request.from, request.frame, read, Interruption::requested);
  if (scene.conductors.empty())
    throw InputError(scene.path + " has no conductors, so there is no motion: `lichtenberg solve` solves its field");
  if (!request.file.empty()) scene.output.file = request.file;
  effects::check_processes(scene.effects.has(&EffectKind::field) ? &scene.field_table : nullptr);
  effects::check_device(scene);
  if (scene.reference && is_for_cuda(scene)) granular::device::check_scene(scene);
  return effects::with_field_chosen(std::move(scene));
}

[[noreturn]] void stop_before_start() {
  fmt::print(stderr, "lichtenberg: stopped before the run began: nothing was written\n");
  Interruption::end_by_signal();
}

/// Reads the scene so that a signal can stop it: positions of conductors may take minutes, the choice of a method
/// seconds.
Scene interruptible_scene(const RunArguments& request, Interruption& interruption) {
  try {
    Scene scene = requested_scene(request);
    interruption.begin();
    if (!Interruption::requested()) return scene;
  } catch (const Stopped&) {
  }
  stop_before_start();
}

std::unique_ptr<Motion> make_motion(const Scene& scene) {
  if (scene.effects.has(&EffectKind::packing)) return std::make_unique<Minimization>(scene);
  if (scene.reference)
    return std::make_unique<GranularMotion>(scene,
                                            is_for_cuda(scene) ? granular::device::make_cuda_gas(scene) : nullptr);
  return std::make_unique<Simulation>(scene);
}

/// Throws InputError if a picture of the run would replace a file, unless the result is replaced too.
void check_pictures(const RunArguments& request, const Scene& scene) {
  if (!scene.output.picture || request.resume || request.overwrite) return;
  const std::string stem = std::filesystem::path(scene.output.file).replace_extension().string();
  for (const char* end : {".png", "-series.png"})
    if (std::filesystem::exists(stem + end) && (*end == '.' || scene.reference))
      throw InputError(fmt::format(
          "the file {} exists, where the run writes its picture: give another name with --out, or allow --overwrite",
          stem + end));
}

Recorder open_recorder(const RunArguments& request, const Scene& scene) {
  check_writable(scene.output.file);  // also reports names that no file can have
  if (request.resume) {
    try_reading(scene.output.file, [&] { Recorder::resume(scene.output.file, scene); });
    return Recorder::resume(scene.output.file, scene);
  }
  check_not_read(scene.output.file, {request.scene, request.from});
  if (!std::filesystem::exists(scene.output.file)) check_pictures(request, scene);
  return Recorder::start(scene.output.file, scene, make_bodies(scene).mass, request.overwrite);
}

/// Throws Failure if a frame holds non-finite numbers. Call it before the frame is written.
void check_finite(const Frame& frame) {
  for (const char* name : {"position", "velocity", "charge", "force"}) {
    const Column* column = frame.find(name);
    const auto* values = column ? std::get_if<std::vector<double>>(&column->values) : nullptr;
    if (values && !std::ranges::all_of(*values, [](double value) { return std::isfinite(value); }))
      throw Failure(fmt::format("at {} a {} is not finite: the scene's numbers are too large or too small",
                                instant_in_words(frame.time, frame.time_unit), name));
  }
}

/// Run of a scene from its start or last checkpoint to its end.
///
/// A checkpoint may discard state of the motion that it cannot store, which changes the last digits of the following
/// results. Unless the motion's checkpoints are exact, they are written only at frames with fixed indices and at the
/// end. A resumed run then discards the same state at the same instants and is bitwise identical to an uninterrupted
/// one. A run that fails leaves a checkpoint at its last frame.
///
/// If the motion leaves a core free, another thread assembles and writes frames and checkpoints, in order and with
/// bitwise identical results, at most one frame behind. Messages about the file appear only after it is written.
class Run {
 public:
  Run(const RunArguments& request, const Scene& scene)
      : request_(request),
        scene_(scene),
        recorder_(open_recorder(request, scene_)),
        frames_(recorder_.frames()),
        motion_(make_motion(scene_)),
        write_queue_(motion_->leaves_a_core() ? tasks_per_frame : 0) {
    if (!recorder_.warning().empty()) fmt::print(stderr, "lichtenberg: {}\n", printable(recorder_.warning()));
    if (recorder_.checkpoint()) motion_->restore(*recorder_.checkpoint());
  }

  /// Advances to the end of the run, then writes and unlocks the file.
  void run_to_end() {
    if (scene_.field_accuracy() && !request_.quiet) fmt::print("field          {}\n", choice_in_words(scene_.field()));
    warn_of_scene();
    const bool may_end_before = scene_.stop.stationary && scene_.effects.has(&EffectKind::field);
    const ProgressMeasure work_range = motion_->progress_measure();
    Progress progress(work_range.done, work_range.whole, request_.quiet, may_end_before);
    update_frame();
    if (frames_ == 0) record(progress);
    while (!finished_) {
      const double due = motion_->next_frame();
      advance(due, progress);
      update_frame();
      if (finished_ || motion_->time() >= due) record(progress);
      make_frame_ = nullptr;  // discard a frame that will not be recorded
      if (!finished_ && progress.due()) progress.show(motion_->progress(), motion_->progress_measure().done);
      if (Interruption::requested() && (saved_ || motion_->exact_anywhere())) save_and_stop(progress);
    }
    if (!end_saved_) save_end(progress);
    unlock();
  }

  void report() {
    if (scene_.output.picture) draw_picture(scene_.output.file, picture_seconds_);
    if (!request_.quiet) print_summary();
    print_warnings(summary_.warnings);
  }

 private:
  /// Prints warnings that follow from the scene alone, before the work. The result stores them too.
  void warn_of_scene() const {
    for (const std::string& warning :
         {effects::unresolved_bodies(scene_), scene_.reference ? granular::stages_warning(scene_) : std::string()})
      if (!warning.empty()) fmt::print(stderr, "lichtenberg: {}\n", printable(warning));
  }

  void update_frame() {
    make_frame_ = motion_->frame_later();
    finished_ = motion_->finished();
  }

  /// Advances to the next frame. If that fails, saves the state of the last frame.
  void advance(double due, Progress& progress) {
    saved_ = false;
    const auto pause = [&] {
      if (!motion_->exact_anywhere()) return Interruption::urgent();
      if (progress.due()) progress.show(motion_->progress(), motion_->progress_measure().done);
      return Interruption::requested() || write_queue_.has_failed();
    };
    try {
      motion_->advance_to(due, pause);
    } catch (const Paused&) {
      stop_at_checkpoint(progress);
    } catch (const Failure& failure) {
      // the failure may be of this process only, and saving needs all processes
      if (parallel::process_count() > 1) throw;
      progress.end_line();
      save_last_state(failure);
      throw Failure(
          fmt::format("{}; {} holds the run up to {}, and --resume continues from there; to change the scene, use "
                      "--from {} --out ANOTHER",
                      failure.what(), scene_.output.file, instant(*recorder_.saved_time()), scene_.output.file));
    }
    if (write_queue_.has_failed()) write_queue_.finish();
  }

  /// Saves the state of the last frame. If that fails too, the message reports both failures.
  void save_last_state(const Failure& failure) {
    try {
      write_queue_.finish();
      if (last_state_) recorder_.save({.checkpoint = *last_state_, .seconds = seconds()});
    } catch (const Failure& disk_failure) {
      throw Failure(fmt::format("{}; and {}", failure.what(), disk_failure.what()));
    }
  }

  void record(Progress& progress) {
    Interruption::suspend_time_limit();
    const std::int64_t index = frames_++;
    {
      const Stopwatch stopwatch(recording_seconds_);
      write_queue_.add([this, frame = std::exchange(make_frame_, nullptr)] {
        Frame now = frame();
        check_finite(now);
        recorder_.add(std::move(now));
      });
    }
    if (finished_) return save(progress);
    if (index % scene_.output.checkpoint_every == 0) return save_in_background(progress);
    last_state_ = motion_->snapshot();
  }

  static void warn(const std::string& warning, Progress& progress) {
    progress.end_line();
    fmt::print(stderr, "lichtenberg: {}\n", printable(warning));
  }

  /// Saves a checkpoint in the background, with the data deferred since the last frame, while the motion continues.
  void save_in_background(Progress& progress) {
    for (const std::string& warning : motion_->warnings()) warn(warning, progress);
    const Stopwatch stopwatch(recording_seconds_);
    write_queue_.add([this, keep = motion_->saved_state_later(), seconds = seconds()] {
      auto [checkpoint, history] = keep();
      recorder_.save({.checkpoint = std::move(checkpoint), .seconds = seconds, .history = std::move(history)});
    });
    last_state_.reset();
    saved_ = true;
  }

  void save(Progress& progress) {
    for (const std::string& warning : motion_->warnings()) warn(warning, progress);
    const Stopwatch stopwatch(recording_seconds_);
    write_queue_.finish();
    Milestone milestone;
    if (finished_) {
      if (const std::string warning = recorder_.warning_of_columns(); !warning.empty()) warn(warning, progress);
      milestone.field = field();  // for other instants `plot` solves the field from the frame
      update_summary();
      milestone.summary = summary_.quantities;
      milestone.warnings = summary_.warnings;
      milestone.findings = motion_->findings();
    }
    milestone.checkpoint = motion_->checkpoint();
    milestone.history = motion_->take_history();
    milestone.seconds = seconds();
    if (const std::string warning = recorder_.save(milestone); !warning.empty()) warn(warning, progress);
    last_state_.reset();
    saved_ = true;
    end_saved_ = finished_;
  }

  std::optional<laplace::Field> field() {
    return scene_.output.field == StoredField::none ? std::nullopt : motion_->field();
  }

  void update_summary() { summary_ = motion_->summary(); }

  /// Completes the file of a run that was over when it was resumed. The last instant may have been saved but not as the
  /// end, frames may not be merged, or the present [stop] may define another end. A run past a reduced [stop] stays
  /// unchanged.
  void save_end(Progress& progress) {
    write_queue_.finish();
    if (recorder_.saved_time() != motion_->time()) return record(progress);
    update_summary();
    if (motion_->time() > motion_->end_time()) return;
    const auto value = [&](const std::vector<Quantity>& all) {
      const auto found = std::ranges::find(all, summary_.goal, &Quantity::name);
      return found == all.end() ? -1.0 : found->value;
    };
    if (value(recorder_.summary()) != value(summary_.quantities) || !recorder_.in_one_file()) save(progress);
  }

  [[noreturn]] void save_and_stop(Progress& progress) {
    Interruption::suspend_time_limit();
    if (!saved_) save(progress);
    stop_at_checkpoint(progress);
  }

  /// Stops at the last checkpoint. A checkpoint at another instant would change the resumed run. Frames after it remain
  /// readable.
  [[noreturn]] void stop_at_checkpoint(Progress& progress) {
    Interruption::suspend_time_limit();
    progress.end_line();
    write_queue_.finish();
    recorder_.save_frames_alone();
    const std::string last = instant(recorder_.last_time()), saved = instant(*recorder_.saved_time());
    fmt::print(stderr, "lichtenberg: stopped at {}; the same command with --resume continues from {}\n", last,
               last == saved ? "there" : "its checkpoint at " + saved);
    unlock();
    Interruption::end_by_signal();
  }

  void unlock() { const Recorder done = std::move(recorder_); }

  std::string instant(double time) const { return instant_in_words(time, motion_->time_unit()); }

  std::map<std::string, double> seconds() const {
    std::map<std::string, double> all = motion_->seconds();
    all["recording"] = recording_seconds_;
    all["picture"] = picture_seconds_;
    return all;
  }

  void print_summary() const {
    fmt::print("{} {}\n", printable(scene_.output.file), summary_.title);
    for (const auto& [label, text] : summary_.lines) fmt::print("{:<15}{}\n", label, printable(text));
    const std::map<std::string, double> activities = seconds();
    double total = 0;
    for (const auto& [activity, value] : activities) total += value;
    std::string parts;
    for (const auto& [activity, value] : activities)
      parts += fmt::format("{} {} {}", parts.empty() ? "" : ",", activity, duration(value));
    fmt::print("{:<15}{}:{}\n", "time", duration(total), parts);
  }

  RunArguments request_;
  Scene scene_;
  Recorder recorder_;
  std::int64_t frames_;  ///< all frames of the run so far, including those still to be written
  std::unique_ptr<Motion> motion_;
  std::function<Frame()> make_frame_;
  bool finished_ = false;
  bool saved_ = true;       ///< the file holds the state of the last frame
  bool end_saved_ = false;  ///< the file holds the end of the run
  Summary summary_;
  std::optional<Checkpoint> last_state_;  ///< state of the last frame if it is not saved
  double recording_seconds_ = 0, picture_seconds_ = 0;
  static constexpr std::size_t tasks_per_frame = 2;  ///< tasks per frame: the frame and its checkpoint
  parallel::TaskQueue write_queue_;  ///< tasks that write the file; destroyed first because they use the other members
};

void run(const RunArguments& request) {
  output_is_optional();
  std::optional<Run> run;
  {
    Interruption interruption(Interruption::Work::preparing);
    const Scene scene = interruptible_scene(request, interruption);
    run.emplace(request, scene);
    run->run_to_end();
  }
  if (Interruption::requested())
    Interruption::end_by_signal();  // the signal came after all was saved; no pictures are drawn
  run->report();
}

}  // namespace

Command run_command() {
  auto request = std::make_shared<RunArguments>();
  const std::vector<Argument> from = from_arguments(request->from, request->frame);
  return {"run",
          "Simulates a scene in time and records the result",
          {{"SCENE", &request->scene, "scene file (.toml)", {.required = true}},
           {"--out", &request->file, "result file (default: output.file of the scene)"},
           device_argument(request->device),
           set_argument(request->settings),
           from[0],
           from[1],
           {"--resume", &request->resume, "continue from the checkpoint in the result file"},
           {"--overwrite",
            &request->overwrite,
            "replace the result file and its pictures if they exist",
            {.excluded = "--resume"}},
           {"--quiet", &request->quiet, "print only errors"}},
          [request] { run(*request); }};
}

}  // namespace lichtenberg
