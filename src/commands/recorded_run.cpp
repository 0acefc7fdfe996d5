#include "src/commands/recorded_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "solvers/error.hpp"
#include "solvers/stopwatch.hpp"
#include "src/commands/device.hpp"
#include "src/commands/interruption.hpp"
#include "src/commands/motion_kind.hpp"
#include "src/effects/field_choice.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/mechanics/simulation.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg {
namespace {

const MotionKind& motion_of(const Scene& scene) {
  return *std::ranges::find_if(motion_kinds(), [&](const MotionKind& kind) { return kind.takes(scene); });
}

}  // namespace

void check_field_device(const Scene& scene) {
  if (is_for_cuda(scene) && !scene.effects.has(&EffectKind::field))
    throw InputError(scene.path +
                     ": the device cuda is for grains and for fields of conductors; this scene has neither");
}

MotionKind conductor_motion() {
  return {.takes = [](const Scene&) { return true; },
          .make = [](const Scene& scene) -> std::unique_ptr<Motion> { return std::make_unique<Simulation>(scene); },
          .check_device = check_field_device};
}

Scene prepare_run(Scene scene) {
  if (scene.conductors.empty())
    throw InputError(scene.path + " has no conductors, so there is no motion: `lichtenberg solve` solves its field");
  effects::check_processes(scene.effects.has(&EffectKind::field) ? &scene.field_table : nullptr);
  effects::check_device(scene);
  if (const MotionKind& kind = motion_of(scene); kind.check_device) kind.check_device(scene);
  return effects::with_field_chosen(std::move(scene));
}

namespace {

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

}  // namespace

RecordedRun::RecordedRun(Scene scene, std::optional<Recorder> recorder, std::function<void(const std::string&)> warn)
    : scene_(std::move(scene)),
      recorder_(std::move(recorder)),
      warn_(std::move(warn)),
      frames_(recorder_ ? recorder_->frames() : 0),
      motion_(motion_of(scene_).make(scene_)),
      write_queue_(motion_->leaves_a_core() ? tasks_per_frame : 0) {
  if (!recorder_) return;
  if (!recorder_->warning().empty()) warn_(recorder_->warning());
  if (recorder_->checkpoint()) motion_->restore(*recorder_->checkpoint());
}

void RecordedRun::begin() {
  const MotionKind& kind = motion_of(scene_);
  for (const std::string& warning :
       {effects::unresolved_bodies(scene_), kind.warning ? kind.warning(scene_) : std::string()})
    if (!warning.empty()) warn_(warning);
  update_frame();
  if (frames_ == 0) record();
}

void RecordedRun::to_next_frame(const std::function<bool()>& pause) {
  const double due = motion_->next_frame();
  saved_ = false;
  try {
    motion_->advance_to(due, [&] { return pause() || (motion_->exact_anywhere() && write_queue_.has_failed()); });
  } catch (const Paused&) {
    throw;
  } catch (const Failure& failure) {
    try {
      save_last_state();
    } catch (const Failure& disk_failure) {
      throw Failure(fmt::format("{}; and {}", failure.what(), disk_failure.what()));
    }
    throw;
  } catch (...) {  // of a force function, for example
    save_last_state();
    throw;
  }
  if (write_queue_.has_failed()) write_queue_.finish();
  update_frame();
  if (finished_ || motion_->time() >= due) record();
  make_frame_ = nullptr;  // discard a frame that will not be recorded
}

void RecordedRun::end() {
  if (!end_saved_) save_end();
  if (recorder_) is_in_one_file_ = recorder_->in_one_file();
  recorder_.reset();
}

std::pair<std::string, std::string> RecordedRun::stop() {
  write_queue_.finish();
  recorder_->save_frames_alone();
  is_in_one_file_ = recorder_->in_one_file();
  std::pair instants{instant(recorder_->last_time()), instant(*recorder_->saved_time())};
  recorder_.reset();
  return instants;
}

std::map<std::string, double> RecordedRun::seconds() const {
  std::map<std::string, double> all = motion_->seconds();
  all["recording"] = recording_seconds_;
  all["picture"] = 0;  // drawn after the run
  return all;
}

void RecordedRun::update_frame() {
  if (recorder_) make_frame_ = motion_->frame_later();
  finished_ = motion_->finished();
}

void RecordedRun::record() {
  Interruption::suspend_time_limit();
  const std::int64_t index = frames_++;
  if (recorder_) {
    const Stopwatch stopwatch(recording_seconds_);
    write_queue_.add([this, frame = std::exchange(make_frame_, nullptr)] {
      Frame now = frame();
      check_finite(now);
      recorder_->add(std::move(now));
    });
  }
  if (finished_) return save();
  if (index % scene_.output.checkpoint_every == 0) return save_in_background();
  if (recorder_) last_state_ = motion_->snapshot();
}

/// Saves a checkpoint in the background, with the data deferred since the last frame, while the motion continues.
void RecordedRun::save_in_background() {
  for (const std::string& warning : motion_->warnings()) warn_(warning);
  const Stopwatch stopwatch(recording_seconds_);
  if (!recorder_) {
    motion_->saved_state_later()();  // may discard state of the motion, as in a recorded run
    return;
  }
  write_queue_.add([this, keep = motion_->saved_state_later(), seconds = seconds()] {
    auto [checkpoint, history] = keep();
    recorder_->save({.checkpoint = std::move(checkpoint), .seconds = seconds, .history = std::move(history)});
  });
  last_state_.reset();
  saved_ = true;
}

void RecordedRun::save() {
  for (const std::string& warning : motion_->warnings()) warn_(warning);
  const Stopwatch stopwatch(recording_seconds_);
  write_queue_.finish();
  Milestone milestone;
  if (finished_) {
    if (recorder_) {
      if (const std::string warning = recorder_->warning_of_columns(); !warning.empty()) warn_(warning);
      milestone.field = field();  // for other instants `plot` solves the field from the frame
    }
    summary_ = motion_->summary();
  }
  if (!recorder_) return;
  if (finished_) {
    milestone.summary = summary_.quantities;
    milestone.warnings = summary_.warnings;
    milestone.findings = motion_->findings();
  }
  milestone.checkpoint = motion_->checkpoint();
  milestone.history = motion_->take_history();
  milestone.seconds = seconds();
  if (const std::string warning = recorder_->save(milestone); !warning.empty()) warn_(warning);
  last_state_.reset();
  saved_ = true;
  end_saved_ = finished_;
}

std::optional<laplace::Field> RecordedRun::field() {
  return scene_.output.field == StoredField::none ? std::nullopt : motion_->field();
}

/// Saves the state of the last frame, unless the step has failed in this process only: saving needs all processes.
void RecordedRun::save_last_state() {
  if (!recorder_ || parallel::process_count() > 1) return;
  write_queue_.finish();
  if (last_state_) recorder_->save({.checkpoint = *last_state_, .seconds = seconds()});
}

/// Completes the file of a run that was over when it was resumed. The last instant may have been saved but not as the
/// end, frames may not be merged, or the present [stop] may define another end. A run past a reduced [stop] stays
/// unchanged.
void RecordedRun::save_end() {
  write_queue_.finish();
  if (!recorder_) return;
  if (recorder_->saved_time() != motion_->time()) return record();
  summary_ = motion_->summary();
  if (motion_->time() > motion_->end_time()) return;
  const auto value = [&](const std::vector<Quantity>& all) {
    const auto found = std::ranges::find(all, summary_.goal, &Quantity::name);
    return found == all.end() ? -1.0 : found->value;
  };
  if (value(recorder_->summary()) != value(summary_.quantities) || !recorder_->in_one_file()) save();
}

}  // namespace lichtenberg
