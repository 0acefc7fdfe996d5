#include <fmt/format.h>

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "solvers/error.hpp"
#include "solvers/parallel/petsc.hpp"
#include "src/commands/commands.hpp"
#include "src/commands/device.hpp"
#include "src/commands/field_problem.hpp"
#include "src/commands/interruption.hpp"
#include "src/commands/json_output.hpp"
#include "src/commands/output.hpp"
#include "src/commands/progress.hpp"
#include "src/commands/python.hpp"
#include "src/commands/reading.hpp"
#include "src/commands/recorded_run.hpp"
#include "src/commands/start_from.hpp"
#include "src/commands/streams.hpp"
#include "src/effects/field_choice.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/record/atomic_file.hpp"
#include "src/record/recorder.hpp"
#include "src/scene/effect_kind.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {
namespace {

struct RunArguments {
  std::string scene, file, device, from;
  std::vector<std::string> settings;
  std::optional<int> frame;
  JsonTarget json;
  bool resume = false, overwrite = false, quiet = false;
};

Scene requested_scene(const RunArguments& request) {
  const auto read = [&](const std::vector<Conductor>& bodies) {
    return read_scene_for(request.scene, request.device, request.settings, Interruption::requested, bodies);
  };
  Scene scene = read_started(request.from, request.frame, read, Interruption::requested);
  if (!request.file.empty()) scene.output.file = request.file;
  return prepare_run(std::move(scene));
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

/// Returns the paths of the pictures that are drawn at the end.
std::vector<std::string> pictures_of(const Scene& scene) {
  if (!scene.output.picture) return {};
  const std::string stem = std::filesystem::path(scene.output.file).replace_extension().string();
  std::vector<std::string> pictures{stem + ".png"};
  if (scene.reference) pictures.push_back(stem + "-series.png");
  return pictures;
}

/// Throws InputError if a picture of the run would replace a file, unless the result is replaced too.
void check_pictures(const RunArguments& request, const Scene& scene) {
  if (request.resume || request.overwrite) return;
  for (const std::string& picture : pictures_of(scene))
    if (std::filesystem::exists(picture))
      throw InputError(fmt::format(
          "the file {} exists, where the run writes its picture: give another name with --out, or give --overwrite",
          picture));
}

Recorder open_recorder(const RunArguments& request, const Scene& scene) {
  if (!request.resume) check_not_read(scene.output.file, {request.scene, request.from});
  check_writable(scene.output.file);  // also reports names that no file can have
  std::vector<std::string> written = pictures_of(scene);
  written.insert(written.end(), {scene.output.file, request.json.file()});
  check_different(written);
  check_outputs({request.json.file()}, {request.scene, request.from}, request.overwrite);
  if (request.resume) {
    try_reading(scene.output.file, [&] { Recorder::resume(scene.output.file, scene); });
    return Recorder::resume(scene.output.file, scene);
  }
  if (!std::filesystem::exists(scene.output.file)) check_pictures(request, scene);
  return Recorder::start(scene.output.file, scene, make_bodies(scene).mass, request.overwrite);
}

/// Runs a scene for the command line: shows progress, obeys signals and draws the picture.
class Run {
 public:
  Run(const RunArguments& request, const Scene& scene)
      : request_(request), run_(scene, open_recorder(request, scene), [this](const std::string& text) { warn(text); }) {
    const ProgressMeasure work_range = run_.motion().progress_measure();
    const bool may_end_before = scene.stop.stationary && scene.effects.has(&EffectKind::field);
    progress_.emplace(work_range.done, work_range.whole, request_.quiet, may_end_before);
  }

  /// Advances to the end of the run, then writes and unlocks the file.
  void run_to_end() {
    const Scene& scene = run_.scene();
    if (scene.field_accuracy() && prints_text()) fmt::print("field          {}\n", choice_in_words(scene.field()));
    Motion& motion = run_.motion();
    const auto pause = [&] {
      if (!motion.exact_anywhere()) return Interruption::urgent();
      if (progress_->due()) progress_->show(motion.progress(), motion.progress_measure().done);
      return Interruption::requested();
    };
    run_.begin();
    while (!run_.finished()) {
      try {
        run_.to_next_frame(pause);
      } catch (const Paused&) {
        stop_at_checkpoint();
      } catch (const Failure& failure) {
        progress_->end_line();
        if (parallel::process_count() > 1 || run_.saved_instant().empty()) throw;
        throw Failure(
            fmt::format("{}; {} holds the run up to {}, and --resume continues from there; to change the scene, "
                        "use --from {} --out ANOTHER",
                        failure.what(), scene.output.file, run_.saved_instant(), scene.output.file));
      }
      if (!run_.finished() && progress_->due()) progress_->show(motion.progress(), motion.progress_measure().done);
      if (Interruption::requested() && (run_.saved() || motion.exact_anywhere())) save_and_stop();
    }
    run_.end();
  }

  void report() {
    if (run_.scene().output.picture) draw_picture(run_.scene().output.file, picture_seconds_);
    if (prints_text()) print_summary();
    request_.json.put(summary_json(), 1);
    print_warnings(run_.summary().warnings);
  }

 private:
  bool prints_text() const { return !request_.quiet && !request_.json.printed(); }

  void warn(const std::string& warning) {
    if (progress_) progress_->end_line();
    fmt::print(stderr, "lichtenberg: {}\n", printable(warning));
  }

  [[noreturn]] void save_and_stop() {
    Interruption::suspend_time_limit();
    if (!run_.saved()) run_.save();
    stop_at_checkpoint();
  }

  /// Stops at the last checkpoint. A checkpoint at another instant would change the resumed run. Frames after it remain
  /// readable.
  [[noreturn]] void stop_at_checkpoint() {
    Interruption::suspend_time_limit();
    progress_->end_line();
    const auto [last, saved] = run_.stop();
    fmt::print(stderr, "lichtenberg: stopped at {}; the same command with --resume continues from {}\n", last,
               last == saved ? "there" : "its checkpoint at " + saved);
    Interruption::end_by_signal();
  }

  /// Returns the wall time (s) by activity.
  std::map<std::string, double> seconds() const {
    std::map<std::string, double> activities = run_.seconds();
    activities["picture"] = picture_seconds_;
    return activities;
  }

  nlohmann::ordered_json summary_json() const {
    const Summary& summary = run_.summary();
    nlohmann::ordered_json json{{"file", run_.scene().output.file}, {"title", run_.scene().title}};
    for (const Quantity& quantity : summary.quantities)
      json["quantities"][quantity.name] = {{"value", quantity.value}, {"unit", quantity.unit}};
    json["seconds"] = seconds();
    json["warnings"] = summary.warnings;
    return json;
  }

  void print_summary() const {
    const Summary& summary = run_.summary();
    fmt::print("{} {}\n", printable(run_.scene().output.file), summary.title);
    for (const auto& [label, text] : summary.lines) fmt::print("{:<15}{}\n", label, printable(text));
    const std::map<std::string, double> activities = seconds();
    double total = 0;
    for (const auto& [activity, value] : activities) total += value;
    std::string parts;
    for (const auto& [activity, value] : activities)
      parts += fmt::format("{} {} {}", parts.empty() ? "" : ",", activity, duration(value));
    fmt::print("{:<15}{}:{}\n", "time", duration(total), parts);
  }

  RunArguments request_;
  std::optional<Progress> progress_;
  RecordedRun run_;
  double picture_seconds_ = 0;
};

void run(const RunArguments& request) {
  if (!request.json.printed()) output_is_optional();
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
           overwrite_argument(request->overwrite, "--resume"),
           json_argument(request->json, "the quantities at the end of the run and the wall time"),
           quiet_argument(request->quiet, "; print only warnings and errors")},
          [request] { run(*request); }};
}

}  // namespace lichtenberg
