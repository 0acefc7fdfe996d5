#include "src/commands/analyse.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <span>
#include <utility>

#include "solvers/error.hpp"
#include "src/commands/analyse_columns.hpp"
#include "src/commands/analyse_gas.hpp"
#include "src/commands/commands.hpp"
#include "src/commands/json_output.hpp"
#include "src/commands/output.hpp"
#include "src/commands/reading.hpp"
#include "src/commands/streams.hpp"
#include "src/record/atomic_file.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg {
namespace {

struct AnalyseArguments {
  std::string file, csv;
  std::optional<int> frame;
  bool overwrite = false;
  JsonTarget json;
  std::string not_stored;  ///< reason why the results are only printed; empty if they are stored
};

/// Analyses the frames of a result file of conductors.
class Analyser {
 public:
  Analyser(const Result& result, Scene scene)
      : result_(result), scene_(with_contacts(std::move(scene))), radius_(result_.radius()), mass_(result_.mass()) {}

  AnalysedRun run() const {
    const double sum = std::accumulate(radius_.begin(), radius_.end(), 0.0);
    return {.file = result_.path(),
            .title = scene_.title,
            .conductors = static_cast<int>(radius_.size()),
            .frames = result_.frames(),
            .radius = radius_.empty() ? 0 : sum / static_cast<double>(radius_.size()),
            .contacts_recorded = result_.contacts(0).has_value(),
            .warnings = result_.warnings()};
  }

  std::vector<FrameAnalysis> all() const {
    std::vector<FrameAnalysis> found;
    ConductorFrame before, now;
    for (int k = 0; k < result_.frames(); ++k) {
      now = result_.conductor_frame(k);
      found.push_back(analyse(k, now));
      if (k > 0) add_dissipation(found[k], now, found[k - 1].power, before);
      before = std::move(now);
    }
    return found;
  }

  FrameAnalysis one(int index) const {
    const ConductorFrame now = result_.conductor_frame(index);
    FrameAnalysis found = analyse(index, now);
    if (index == 0) return found;
    const ConductorFrame before = result_.conductor_frame(index - 1);
    add_dissipation(found, now, analysis::power(scene_, before, mass_), before);
    return found;
  }

 private:
  Scene with_contacts(Scene scene) const {
    if (!result_.has_network())
      throw InputError(fmt::format(
          "the result file {} has no network to analyse, because its scene has no table [effects.contact_discharge]",
          result_.path()));
    if (scene.conductors.size() != result_.radius().size())
      throw InputError(fmt::format(
          "the result file {} is damaged and cannot be analysed (its scene has {} conductors, but its frames have {})",
          result_.path(), scene.conductors.size(), result_.radius().size()));
    return scene;
  }

  FrameAnalysis analyse(int index, const ConductorFrame& frame) const {
    const analysis::Ground ground = analysis::ground_of(scene_);
    // For spheres the spanning tree and the dimensions are those of the projection onto the front plane.
    const std::vector<Vec2> position = analysis::xy_projection(frame.position);
    analysis::ContactNetwork network = analysis::network(contacts(index, position, ground), frame.position);
    return {.frame = index,
            .time = frame.time,
            .topology = analysis::topology(std::move(network), position, radius_, ground),
            .power = analysis::power(scene_, frame, mass_),
            .dissipated = {},
            .recorded = recorded(index)};
  }

  /// Returns the recorded contacts of a frame. Without a record, returns the contacts of D 7.1, which certainly exist,
  /// and the edges of the recorded tree. This set lacks only contacts that close a loop and exist by hysteresis alone.
  std::vector<analysis::Edge> contacts(int index, std::span<const Vec2> position,
                                       const analysis::Ground& ground) const {
    if (auto recorded = result_.contacts(index)) return *recorded;
    auto found = analysis::contacts(position, radius_, number_in(scene_, &EffectKind::contact_gap).value_or(0), ground);
    const std::vector<int> successor = result_.successor(index);
    for (int i = 0; i < static_cast<int>(successor.size()); ++i) {
      if (successor[i] == analysis::to_ground) found.emplace_back(i, analysis::to_ground);
      if (successor[i] >= 0) found.emplace_back(std::minmax(i, successor[i]));
    }
    std::ranges::sort(found);
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
  }

  std::vector<RecordedQuantity> recorded(int index) const {
    std::vector<RecordedQuantity> result;
    for (RecordedQuantity found : {RecordedQuantity{"current", "A", true, {}},
                                   {"structure_resistance", "ohm", false, {}},
                                   {"supplied_power", "W", false, {}},
                                   {"dissipated_power", "W", false, {}},
                                   {"entropy_production", "W K-1", false, {}}}) {
      found.values = result_.observable(found.name, index);
      if (!found.values.empty()) result.push_back(std::move(found));
    }
    return result;
  }

  void add_dissipation(FrameAnalysis& found, const ConductorFrame& now, const analysis::Power& power_before,
                       const ConductorFrame& before) const {
    const auto known = std::ranges::find(found.recorded, "dissipated_power", &RecordedQuantity::name);
    found.dissipated = known != found.recorded.end()
                           ? known->values.front()
                           : analysis::dissipated_power(scene_, before, power_before, now, found.power);
  }

  const Result& result_;
  Scene scene_;
  std::vector<double> radius_, mass_;
};

/// Prints the analysis and, if all frames are analysed, stores it in the result file.
template <class Analysis>
void analyse(const Analysis& analyser, const Result& result, const AnalyseArguments& request) {
  const auto found = request.frame ? std::vector{analyser.one(*request.frame)} : analyser.all();
  warn_if_changed(result.file());
  if (!request.json.printed()) print_analysis(analyser.run(), found);
  if (!request.json.word.empty()) request.json.put(analysis_json(analyser.run(), found), 1);
  const std::vector<Column> columns = columns_of(analyser.run(), found);
  if (!request.csv.empty()) {
    const std::string text = csv_of(columns, found.size());
    write_atomically(request.csv, std::as_bytes(std::span(text)));
  }
  if (request.frame) return;
  if (!request.not_stored.empty())
    return fmt::print(stderr, "lichtenberg: nothing is stored: {}\n", printable(request.not_stored));
  result.put_analysis(columns);
  if (!request.json.printed())
    fmt::print("stored         {}:/analysis, all {} frames\n", printable(request.file), found.size());
}

/// Analyses the result and then prints its warnings.
template <class Analysis>
void analyse_and_warn(const Analysis& analyser, const Result& result, const AnalyseArguments& request) {
  analyse(analyser, result, request);
  print_warnings(result.warnings());
}

/// Returns the reason why a result cannot be written (such as a read-only folder); empty if it can.
std::string why_not_stored(const std::string& path) {
  try {
    check_writable(path);
    return "";
  } catch (const InputError& error) {
    return error.what();
  }
}

void analyse(AnalyseArguments& request) {
  check_overwrite(request.overwrite, {request.csv, request.json.file()}, "--csv or --json=FILE");
  read_in_child({request.file});
  const Result result(request.file);
  if (request.frame && (*request.frame < 0 || *request.frame >= result.frames()))
    throw InputError(fmt::format("--frame {} is not in the result file {}: it has frames 0 to {}", *request.frame,
                                 result.path(), result.frames() - 1));
  request.not_stored = why_not_stored(request.file);
  check_outputs({request.csv, request.json.file()}, {request.file}, request.overwrite);
  Scene scene = result.scene();
  if (scene.reference) return analyse_and_warn(GasAnalyser(result, std::move(scene)), result, request);
  analyse_and_warn(Analyser(result, std::move(scene)), result, request);
}

}  // namespace

Command analyse_command() {
  auto request = std::make_shared<AnalyseArguments>();
  return {"analyse",
          "Computes and stores the topology of a run, or temperature, charges and clusters of a gas, frame by frame",
          {{"RESULT", &request->file, "result file of a run (.h5); gets the group /analysis", {.required = true}},
           {"--frame", &request->frame,
            "index of the frame, from 0: only it is analysed, and nothing is stored (default: all frames)"},
           json_argument(request->json, "SI units; for grains those of their scene"),
           {"--csv", &request->csv, "CSV file to write, with one line per frame"},
           overwrite_argument(request->overwrite)},
          [request] { analyse(*request); }};
}

}  // namespace lichtenberg
