#include "src/commands/relax.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "src/analysis/packing.hpp"
#include "src/commands/draw.hpp"
#include "src/commands/interruption.hpp"
#include "src/commands/progress.hpp"
#include "src/commands/summary.hpp"
#include "src/mechanics/counters.hpp"
#include "src/record/frame_columns.hpp"
#include "src/statics/relaxation.hpp"

namespace lichtenberg {
namespace {

/// The first of the numbers round(ratio^k), k = 0, 1, ..., that is larger than `now`.
std::int64_t next_mark(std::int64_t now, double ratio) {
  if (now < 1) return now + 1;
  for (double k = std::floor(std::log(static_cast<double>(now)) / std::log(ratio));; ++k)
    if (const std::int64_t mark = std::llround(std::pow(ratio, k)); mark > now) return mark;
}

/// A relaxation is quick first and slow later.
constexpr double frame_ratio = 1.4142135623730951, history_ratio = 1.02;

class RelaxationRun {
 public:
  RelaxationRun(const Scene& scene, Recorder recorder, bool quiet)
      : scene_(scene), recorder_(std::move(recorder)), quiet_(quiet), relaxation_(scene) {
    if (recorder_.checkpoint()) relaxation_.restore(*recorder_.checkpoint());
    began_at_ = relaxation_.iteration();
    if (recorder_.saved_time() == static_cast<double>(began_at_)) recorded_at_ = began_at_;
    if (recorder_.checkpoint() && (recorder_.finished() || next_note(began_at_ - 1) == began_at_))
      noted_at_ = began_at_;
    next_note_ = next_note(began_at_);
    next_frame_ = next_frame(began_at_);
  }

  void go() {
    if (recorder_.frames() == 0) {
      note();
      recorder_.add(columns_of(relaxation_.frame(), {}));
    }
    go_on_until_rest();
    packing_ = analysis::packing(relaxation_.bodies(), scene_);
    // A run that stopped in its very last iteration has been saved, but not its end; and one that is over may have
    // been resumed with another tolerance.
    if (!is_recorded() || recorded_at_rest() != relaxation_.at_rest()) record_the_end();
    if (scene_.output.picture) draw_picture(scene_.output.file, picture_seconds_);
    if (!quiet_) print_summary();
    if (!relaxation_.at_rest())
      fmt::print(stderr, "lichtenberg: not at rest after {} iterations: {}\n", relaxation_.iteration(),
                 stuck_ ? "the energy goes no lower with the digits that there are"
                        : "minimize.max_iterations allows no more");
  }

 private:
  void go_on_until_rest() {
    const Stopwatch stopwatch(relaxation_seconds_);
    Progress progress(0, 0, quiet_);
    const Interruption interruption;
    while (!relaxation_.at_rest() && relaxation_.iteration() < scene_.minimize.max_iterations) {
      if (stuck_ = !relaxation_.iterate(); stuck_) return;
      const std::int64_t now = relaxation_.iteration();
      if (now == next_note_) note();
      if (now == next_frame_) record_frame();
      if (progress.due()) progress.show(line());
      if (Interruption::requested()) stop_here(progress);
    }
  }

  /// Marks depend on the number of the iteration alone: a resumed run makes the same ones.
  static std::int64_t next_note(std::int64_t now) { return next_mark(now, history_ratio); }
  std::int64_t next_frame(std::int64_t now) const {
    const std::int64_t every = scene_.minimize.record_every;
    return every > 0 ? (now / every + 1) * every : next_mark(now, frame_ratio);
  }

  void note() {
    history_.push_back({relaxation_.iteration(), relaxation_.energy(), relaxation_.largest_force()});
    noted_at_ = relaxation_.iteration();
    next_note_ = next_note(relaxation_.iteration());
  }

  void record_frame() {
    const std::int64_t index = recorder_.frames();
    recorder_.add(columns_of(relaxation_.frame(), {}));
    recorded_at_ = relaxation_.iteration();
    next_frame_ = next_frame(relaxation_.iteration());
    if (index % scene_.output.checkpoint_every == 0) save({});
  }

  /// The file holds this iteration, its note and a summary.
  bool is_recorded() const { return recorder_.finished() && relaxation_.iteration() == began_at_; }
  bool recorded_at_rest() const {
    return hdf5::get<double>(ResultFile(scene_.output.file, "resumed").file(), "summary/at_rest").at(0) != 0;
  }

  void record_the_end() {
    if (recorded_at_ != relaxation_.iteration()) recorder_.add(columns_of(relaxation_.frame(), {}));
    if (noted_at_ != relaxation_.iteration()) note();
    Milestone last;
    last.findings = {columns_of(packing_)};
    last.summary = quantities();
    save(std::move(last));
  }

  void save(Milestone milestone) {
    const Stopwatch stopwatch(recording_seconds_);
    milestone.checkpoint = relaxation_.checkpoint();
    if (!history_.empty()) milestone.history = columns_of(history_);
    milestone.seconds = seconds();
    recorder_.save(milestone);
    history_.clear();
  }

  [[noreturn]] void stop_here(Progress& progress) {
    save({});
    progress.end_line();
    fmt::print(stderr, "lichtenberg: stopped after {} iterations; the same command with --resume goes on from there\n",
               relaxation_.iteration());
    { const Recorder done = std::move(recorder_); }  // which removes its lock
    Interruption::obey();
  }

  std::map<std::string, double> seconds() const {
    return {{"relaxation", relaxation_seconds_}, {"recording", recording_seconds_}, {"picture", picture_seconds_}};
  }

  double force_in_units() const { return relaxation_.largest_force() / relaxation_.force_unit(); }
  std::string line() const {
    return fmt::format("iteration {}: energy {:.10g} J, largest force {:.2e} k/R", relaxation_.iteration(),
                       relaxation_.energy(), force_in_units());
  }

  std::vector<Quantity> quantities() const {
    std::vector<Quantity> all{{"at_rest", relaxation_.at_rest() ? 1.0 : 0.0, "1"},
                              {"iterations", static_cast<double>(relaxation_.iteration()), "1"},
                              {"evaluations", static_cast<double>(relaxation_.evaluations()), "1"},
                              {"energy", relaxation_.energy(), "J"},
                              {"largest_force", relaxation_.largest_force(), "N"},
                              {"relative_largest_force", force_in_units(), "1"},
                              {"contacts", static_cast<double>(packing_.contacts.size()), "1"},
                              {"rattlers", static_cast<double>(packing_.rattlers), "1"},
                              {"coordination", packing_.coordination, "1"},
                              {"backbone_coordination", packing_.backbone_coordination, "1"},
                              {"smallest_q", packing_.smallest_q, "1"}};
    if (!packing_.fraction) return all;
    all.push_back({"packing_fraction", *packing_.fraction, "1"});
    all.push_back({"pressure", *packing_.pressure, pressure_unit()});
    all.push_back({"virial_pressure", *packing_.virial_pressure, pressure_unit()});
    return all;
  }

  const char* pressure_unit() const { return scene_.dimension() == 3 ? "Pa" : "N m-1"; }

  void print_summary() const {
    fmt::print("{} holds the relaxation: {} after {} iterations of {}, {} evaluations\n", scene_.output.file,
               relaxation_.at_rest() ? "at rest" : "not at rest", relaxation_.iteration(), scene_.minimize.method,
               relaxation_.evaluations());
    fmt::print("energy         {:.10g} J\n", relaxation_.energy());
    fmt::print("largest force  {:.3g} N, {:.2e} of stiffness / mean diameter\n", relaxation_.largest_force(),
               force_in_units());
    fmt::print("contacts       {}, smallest q {:.4g}\n", packing_.contacts.size(), packing_.smallest_q);
    fmt::print("coordination   {:.4f}, {:.4f} without the {} rattlers\n", packing_.coordination,
               packing_.backbone_coordination, packing_.rattlers);
    if (packing_.fraction) {
      const char* unit = scene_.dimension() == 3 ? "Pa" : "N/m";
      fmt::print("filled         {:.4f} of the domain\n", *packing_.fraction);
      fmt::print("pressure       {:.6g} {} on the walls, {:.6g} {} from the forces inside\n", *packing_.pressure, unit,
                 *packing_.virial_pressure, unit);
    } else {
      fmt::print("pressure       none, nor how much is filled: there are walls other than the sides of the domain\n");
    }
    for (std::size_t w = 0; w < scene_.walls.size(); ++w)
      fmt::print("wall           {:.6g} N on {}\n", packing_.wall_force[w], scene_.walls[w].name);
    print_seconds(seconds());
  }

  Scene scene_;
  Recorder recorder_;
  bool quiet_, stuck_ = false;
  Relaxation relaxation_;
  std::int64_t began_at_ = 0, recorded_at_ = 0, noted_at_ = -1;
  std::int64_t next_note_ = 0, next_frame_ = 0;
  std::vector<RelaxationState> history_;
  analysis::Packing packing_;
  double relaxation_seconds_ = 0, recording_seconds_ = 0, picture_seconds_ = 0;
};

}  // namespace

void relax(const Scene& scene, Recorder recorder, bool quiet) { RelaxationRun(scene, std::move(recorder), quiet).go(); }

}  // namespace lichtenberg
