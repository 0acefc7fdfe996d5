#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <utility>

#include "solvers/error.hpp"
#include "solvers/laplace/cutcell/petsc.hpp"
#include "src/analysis/circuit.hpp"
#include "src/commands/commands.hpp"
#include "src/commands/device.hpp"
#include "src/commands/draw.hpp"
#include "src/commands/field_problem.hpp"
#include "src/commands/interruption.hpp"
#include "src/commands/progress.hpp"
#include "src/commands/relax.hpp"
#include "src/commands/summary.hpp"
#include "src/effects/contact_discharge.hpp"
#include "src/effects/field_choice.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/mechanics/simulation.hpp"
#include "src/record/frame_columns.hpp"
#include "src/record/recorder.hpp"
#include "src/record/result.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {
namespace {

struct RunArguments {
  std::string scene, file, device;
  bool resume = false, overwrite = false, quiet = false;
};

Scene requested_scene(const RunArguments& request) {
  Scene scene = read_scene_for(request.scene, request.device);
  if (!request.file.empty()) scene.output.file = request.file;
  effects::check_processes(scene.effects.floating_conductors ? &scene.field : nullptr);
  effects::check_device(scene);
  return effects::with_field_chosen(std::move(scene));
}

Recorder open_recorder(const RunArguments& request, const Scene& scene) {
  if (request.resume) return Recorder::resume(scene.output.file, scene);
  return Recorder::start(scene.output.file, scene, make_bodies(scene).mass, request.overwrite);
}

/// The network of the contacts that the simulation has made; none in a scene without contacts.
std::optional<analysis::Network> network_of(const Simulation& simulation, const std::vector<Vec2>& position) {
  const auto* discharge = simulation.model().find<effects::ContactDischarge>();
  if (discharge == nullptr) return {};
  std::vector<analysis::Contact> contacts;
  for (const auto& [conductor, partner] : discharge->contacts())
    contacts.emplace_back(conductor, partner < static_cast<int>(position.size()) ? partner : analysis::to_ground);
  return analysis::network(std::move(contacts), position);
}

/// A scene's run, from its start or its last checkpoint to its end.
///
/// A checkpoint makes the simulation forget what it cannot hold, which changes the last digits of what follows. So
/// checkpoints are made at the frames whose index says so, and at the end, and at no other time: then a resumed run
/// forgets at the same instants as an uninterrupted one and gives the same bits. A run that fails on its way leaves one
/// at its last frame.
class Run {
 public:
  Run(const RunArguments& request, const Scene& scene)
      : request_(request), scene_(scene), recorder_(open_recorder(request, scene_)), simulation_(scene_) {
    if (recorder_.checkpoint()) simulation_.restore(*recorder_.checkpoint());
  }

  void go() {
    if (scene_.field.estimate && !request_.quiet) fmt::print("field          {}\n", choice_in_words(scene_.field));
    advance_to_the_end();
    if (const std::string warning = energy_warning(outcome_, scene_); !warning.empty())
      fmt::print(stderr, "lichtenberg: {}\n", warning);
    if (scene_.output.picture) draw_picture(scene_.output.file, picture_seconds_);
    if (!request_.quiet) print_summary(scene_.output.file, outcome_, simulation_.counters(), seconds());
  }

 private:
  void advance_to_the_end() {
    Progress progress(simulation_.time(), scene_.stop.time, request_.quiet);
    look();
    if (outcome_.frame.energy_balance) outcome_.energy_check = energy_check();
    const Interruption interruption;  // after the first solve, which starts PETSc with handlers of its own
    if (recorder_.frames() == 0) record();
    while (!outcome_.over) {
      const Frame before = simulation_.frame();  // as a checkpoint leaves it, and as a resumed run has it
      advance(progress);
      look();
      if (outcome_.frame.energy_balance)
        outcome_.frame.rates = analysis::circuit_rates(before, outcome_.frame, scene_.medium.temperature);
      record();
      progress.show(outcome_.frame, outcome_.network);
      if (Interruption::requested() && nothing_unsaved_) stop_here(progress);
    }
  }

  /// To the next frame. If that fails, what has been computed until the last one is saved.
  void advance(Progress& progress) {
    try {
      simulation_.advance_to(next_frame());
    } catch (const Failure& failure) {
      if (laplace::process_count() > 1) throw;  // it may be this process's own, and saving takes all
      progress.end_line();
      if (last_state_) save_last_frame();
      throw Failure(fmt::format("{}; {} holds the run up to t = {:.6g} s, and --resume goes on from there",
                                failure.what(), scene_.output.file, *recorder_.saved_time()));
    }
  }

  /// With the field solved again: that of the simulation is of the instant at which it failed.
  void save_last_frame() {
    Milestone milestone{.checkpoint = *last_state_, .seconds = seconds()};
    Simulation then(scene_);
    then.restore(*last_state_);
    if (scene_.effects.floating_conductors) milestone.field = then.field();
    recorder_.save(milestone);
  }

  EnergyCheck energy_check() const {
    const Frame first = request_.resume ? Result(scene_.output.file).frame(0) : outcome_.frame;
    return {.initial = analysis::energy_account(first), .allowed = analysis::allowed_energy_imbalance(scene_)};
  }

  double next_frame() const {
    // The times of frames are multiples of `every`, to rounding: 11 * 0.03 is less than 0.33, but no frame before the
    // end.
    constexpr double rounding = 1e-9;
    const double every = scene_.output.every, stop = scene_.stop.time;
    const double next = every * (std::floor(simulation_.time() / every + rounding) + 1);
    return next < stop - rounding * every ? next : stop;
  }

  void look() {
    outcome_.frame = simulation_.frame();
    outcome_.network = network_of(simulation_, outcome_.frame.position);
    outcome_.stationary = scene_.stop.stationary && simulation_.stationary();
    outcome_.over = outcome_.stationary || simulation_.time() >= scene_.stop.time;
  }

  void record() {
    const std::int64_t index = recorder_.frames();
    recorder_.add(columns_of(outcome_.frame, outcome_.network));
    nothing_unsaved_ = outcome_.over || index % scene_.output.checkpoint_every == 0;
    if (nothing_unsaved_) return save();
    last_state_ = simulation_.snapshot();
  }

  void save() {
    check_accuracy();
    const Stopwatch stopwatch(recording_seconds_);
    Milestone milestone;
    if (scene_.effects.floating_conductors) milestone.field = simulation_.field();
    milestone.checkpoint = simulation_.checkpoint();
    milestone.seconds = seconds();
    if (outcome_.over) milestone.summary = quantities(outcome_);
    recorder_.save(milestone);
    last_state_.reset();
  }

  /// The choice was made at the start, and conductors have moved since.
  void check_accuracy() {
    const auto* field = simulation_.model().find<effects::FloatingConductors>();
    if (field == nullptr || !field->last_problem()) return;
    const Stopwatch stopwatch(checking_seconds_);
    const double asked = *scene_.field.accuracy;
    const double estimate = effects::estimated_error(scene_.field, *field->last_problem());
    if (estimate > asked && outcome_.largest_error.value_or(0) <= asked)
      fmt::print(
          stderr,
          "lichtenberg: at t = {:.6g} s the field's error is estimated at {:.1e}, more than field.accuracy = {:g}\n",
          simulation_.time(), estimate, asked);
    outcome_.largest_error = std::max(outcome_.largest_error.value_or(0), estimate);
  }

  [[noreturn]] void stop_here(Progress& progress) {
    progress.end_line();
    fmt::print(stderr, "lichtenberg: stopped at t = {:.6g} s; the same command with --resume goes on from there\n",
               simulation_.time());
    { const Recorder done = std::move(recorder_); }  // which removes its lock
    Interruption::obey();
  }

  /// Wall time since this program started, by activity.
  std::map<std::string, double> seconds() const {
    const Counters& counters = simulation_.counters();
    std::map<std::string, double> all = {{"field", counters.field_seconds},
                                         {"mechanics", counters.mechanics_seconds},
                                         {"contacts", counters.contact_seconds},
                                         {"recording", recording_seconds_},
                                         {"picture", picture_seconds_}};
    if (scene_.field.accuracy) all["accuracy"] = checking_seconds_;
    return all;
  }

  static double sum(const std::vector<double>& terms) { return std::accumulate(terms.begin(), terms.end(), 0.0); }

  RunArguments request_;
  Scene scene_;
  Recorder recorder_;
  Simulation simulation_;
  Outcome outcome_{.initial_charge = sum(initial_charges(scene_))};
  bool nothing_unsaved_ = true;
  std::optional<Checkpoint> last_state_;  ///< of the last frame, if it is not saved
  double recording_seconds_ = 0, picture_seconds_ = 0, checking_seconds_ = 0;
};

void run(const RunArguments& request) {
  const Scene scene = requested_scene(request);
  if (scene.effects.contact_potential)
    relax(scene, open_recorder(request, scene), request.quiet);
  else
    Run(request, scene).go();
}

}  // namespace

void add_run(CLI::App& program) {
  CLI::App* command = program.add_subcommand("run", "Carries a scene on in time and records it");
  auto request = std::make_shared<RunArguments>();
  command->add_option("SCENE", request->scene, "scene file (.toml)")->required();
  command->add_option("--out", request->file, "result file (default: output.file of the scene)");
  add_device_option(*command, request->device);
  CLI::Option* resume = command->add_flag("--resume", request->resume, "go on from the checkpoint in the result file");
  command->add_flag("--overwrite", request->overwrite, "replace the result file if it exists")->excludes(resume);
  command->add_flag("--quiet", request->quiet, "print nothing but errors");
  command->callback([request] { run(*request); });
}

}  // namespace lichtenberg
